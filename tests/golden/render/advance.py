# window {{window.index}}
advance({{window.begin}}, {{window.end}})
{{^damped}}
check(free=True)
{{/damped}}
