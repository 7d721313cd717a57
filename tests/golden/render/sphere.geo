// {{fluid}}
radius = {{diameter}} / 2;
radii[] = {{radii}};
{{#radii}}
Point(newp) = { {{.}}, 0, {{gravity}}};
{{/radii}}
