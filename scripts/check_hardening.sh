#!/bin/sh
# Fails where a program lacks what protects it from malicious input: PIE, RELRO with all symbols bound at the start, no
# executable stack; with "compiled" also the stack protector and checked functions of libc (MAPLESS_HARDEN).
# usage: scripts/check_hardening.sh PROGRAM [compiled]
set -eu
require() { # what, where, pattern
  printf '%s\n' "$2" | grep -q "$3" || { echo "scripts/check_hardening.sh: $program: no $1" >&2 && exit 1; }
}
program=$1
headers=$(readelf -hlW "$program")
require PIE "$headers" 'Type: *DYN'
require RELRO "$headers" GNU_RELRO
require "stack that is not executable" "$headers" 'GNU_STACK.* RW '
require "binding at the start" "$(readelf -dW "$program")" 'NOW'
[ "${2:-}" = compiled ] || exit 0
symbols=$(readelf --dyn-syms -W "$program")
require "stack protector" "$symbols" __stack_chk_fail
require "checked function of libc" "$symbols" '_chk@'
