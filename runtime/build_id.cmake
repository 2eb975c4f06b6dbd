# Writes build_id.hpp when the commit (or whether the tree is changed) is not what it says. Run at every build.
execute_process(COMMAND git -C "${SOURCE}" describe --always --dirty --abbrev=10 OUTPUT_VARIABLE id
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed OR NOT id)
  set(id "unknown")
endif()
file(CONFIGURE OUTPUT "${OUT}" CONTENT "#pragma once

namespace multireach {

inline constexpr char kVersion[] = \"${VERSION}\";
inline constexpr char kBuildId[] = \"${id}\";

}  // namespace multireach
" @ONLY)
