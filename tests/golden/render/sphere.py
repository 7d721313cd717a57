# {{title}}
{{! parameters first }}
diameter = {{diameter}}
density = {{density}}
gravity = (0, 0, {{gravity}})
radii = {{radii}}
damped = {{damped}}

{{#damped}}
O.engines[-1].damping = 0.509
{{/damped}}
for step in range({{steps}}):
    {{> advance}}

outputs = [{{#fields}}({{name}}, {{unit}}), {{/fields}}]
