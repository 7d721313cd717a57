// The plate under the specimen: a square sheet without thickness, with square holes (ICY, section 4.3).
// Holes are centred in squares of the pitch, so that half a bar runs along each side. Lengths in m.
SetFactory("OpenCASCADE");

width = {{section}};
hole = {{hole}};
n = Round(width/{{hole_pitch}});  // holes along a side
pitch = width/n;
If (n < 1 || hole >= pitch)
  Error("the holes do not fit into the plate");
  Abort;
EndIf

Rectangle(1) = {0, 0, 0, width, width};
holes() = {};
For i In {0 : n - 1}
  For j In {0 : n - 1}
    tool = 100 + i*n + j;
    Rectangle(tool) = {(i + 0.5)*pitch - hole/2, (j + 0.5)*pitch - hole/2, 0, hole, hole};
    holes() += {tool};
  EndFor
EndFor
BooleanDifference(2) = { Surface{1}; Delete; }{ Surface{holes()}; Delete; };
Physical Surface(1) = {2};

// Triangles as large as the bars allow: the sheet is flat, small ones add nothing but work.
Mesh.MeshSizeMin = pitch;
Mesh.MeshSizeMax = pitch;
General.NumThreads = 1;
Mesh 2;
Save "plate.msh";
