# What scripts know of the program's instruction sets, to be sourced: what include/render/instruction_set.hpp
# lists, and what of it this processor has.

listed_sets() { sed -n '/define MLT_INSTRUCTION_SETS/,/[^\\]$/p' include/render/instruction_set.hpp; }

# instruction_sets: their names, one a line.
instruction_sets() { listed_sets | sed -nE 's/^ *X\(([a-z0-9_]+),.*/\1/p'; }

# needs_of SET: what a processor must have for it, one a line, as compilers name it.
needs_of() {
  listed_sets | awk -v set="$1" '/^ *X\(/ { on = index($0, "X(" set ",") } on' |
    grep -oE 'CPU_HAS\("[a-z0-9]+"\)' | cut -d'"' -f2
}

# lacks_for SET: what of that this processor lacks. What compilers call bmi is bmi1 to Linux.
lacks_for() {
  local need lacking=()
  for need in $(needs_of "$1"); do
    grep -qw -e "$need" -e "${need/%bmi/bmi1}" /proc/cpuinfo || lacking+=("$need")
  done
  echo "${lacking[*]}"
}
