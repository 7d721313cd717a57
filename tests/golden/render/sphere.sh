#!/bin/sh
# {{title}}
exec solver --title={{title}} --diameter={{diameter}} --damped={{damped}} {{radii}}
