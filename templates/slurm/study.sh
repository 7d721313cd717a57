#!/bin/bash
# The points of a study as one Slurm job array: task N runs the N-th point, in the folder where the study was started.
case "$SLURM_ARRAY_TASK_ID" in
{{#tasks}}
{{number}})
  exec {{#arguments}}{{.}} {{/arguments}}>{{log}} 2>&1
  ;;
{{/tasks}}
esac
