// A sphere in the middle of a cube, in radii of the sphere: the box of ICY (Pirnia et al. 2019,
// section 3.3). Flow goes along z.
SetFactory("OpenCASCADE");

half = {{box_width}}/{{diameter}};               // half the width of the box
size = 2*{{element_size_ratio}};                 // element size at the sphere (given in diameters)
growth = {{element_growth}};                     // size ratio of two neighbouring elements

{{#quarter}}
low = 0;  // a quarter; the planes x = 0 and y = 0 are planes of symmetry
{{/quarter}}
{{^quarter}}
low = -half;
{{/quarter}}
Box(1) = {low, low, -half, half - low, half - low, 2*half};
Sphere(2) = {0, 0, 0, 1};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };

e = 1e-3;
sphere() = Surface In BoundingBox {-1 - e, -1 - e, -1 - e, 1 + e, 1 + e, 1 + e};
inlet() = Surface In BoundingBox {-half - e, -half - e, -half - e, half + e, half + e, -half + e};
outlet() = Surface In BoundingBox {-half - e, -half - e, half - e, half + e, half + e, half + e};
side_x() = Surface In BoundingBox {low - e, -half - e, -half - e, low + e, half + e, half + e};
side_x() += Surface In BoundingBox {half - e, -half - e, -half - e, half + e, half + e, half + e};
side_y() = Surface In BoundingBox {-half - e, low - e, -half - e, half + e, low + e, half + e};
side_y() += Surface In BoundingBox {-half - e, half - e, -half - e, half + e, half + e, half + e};

Physical Surface(1) = {sphere()};
Physical Surface(2) = {inlet()};
Physical Surface(3) = {outlet()};
Physical Surface(4) = {side_x()};
Physical Surface(5) = {side_y()};
Physical Volume(1) = {3};

// Sizes that grow by a constant ratio from one element to the next grow linearly with the distance.
Field[1] = MathEval;
Field[1].F = Sprintf("%.17g + %.17g*(Sqrt(x*x + y*y + z*z) - 1)", size, growth - 1);
Background Field = 1;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.MeshSizeExtendFromBoundary = 0;
General.NumThreads = 1;

Mesh 3;
Save "sphere_in_box.msh";
