# Writes OUTPUT, a header with one digest per room (or ROOM/FILE) of the sources that decide what a run computes. A study's result is
# kept as long as they stay the same: a program that was only linked again, or shows things in another way, is no reason
# to compute anything anew.  Usage: cmake -D ROOMS="a b" -D FOLDER=... -D OUTPUT=... -P digests.cmake
separate_arguments(ROOMS)
set(rows "")
foreach(room IN LISTS ROOMS)
  if(room MATCHES "/")
    file(GLOB files ${FOLDER}/${room}.[ch]pp)
  else()
    file(GLOB files ${FOLDER}/${room}/*.[ch]pp)
  endif()
  list(SORT files)
  set(text "")
  foreach(file IN LISTS files)
    get_filename_component(name ${file} NAME)
    file(SHA256 ${file} digest)
    string(APPEND text "${name} ${digest}\n")
  endforeach()
  string(SHA256 digest "${text}")
  string(APPEND rows "    {\"${room}\", \"${digest}\"},\n")
endforeach()
list(LENGTH ROOMS count)
file(WRITE ${OUTPUT} "#pragma once

#include <array>
#include <utility>

namespace sandglass::study {

/// Written by orchestrator/digests.cmake: the rooms whose sources decide what a run computes.
inline constexpr std::array<std::pair<const char*, const char*>, ${count}> orchestrator_digests = {{
${rows}}};

}  // namespace sandglass::study
")
