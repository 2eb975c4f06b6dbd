# Writes the definitions of all types as texts into a header, for programs that read messages by their definitions.
# Usage: cmake -DFILES="a.lcm|b.lcm" -DOUT=schema_texts.hpp -P schema_texts.cmake
string(REPLACE "|" ";" files "${FILES}")
set(text "#pragma once\n\n#include <array>\n#include <string_view>\n\nnamespace multireach {\n\n")
list(LENGTH files count)
string(APPEND text "inline constexpr std::array<std::string_view, ${count}> kSchemaTexts{{\n")
foreach(file IN LISTS files)
  file(READ "${file}" definition)
  string(APPEND text "R\"lcm(${definition})lcm\",\n")
endforeach()
string(APPEND text "}};\n\n}  // namespace multireach\n")
file(WRITE "${OUT}" "${text}")
