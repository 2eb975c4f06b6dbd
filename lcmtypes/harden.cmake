# Reads a header that lcm-gen wrote and writes it with every length checked before it is used:
#  - decoding: a count must be non-negative and no larger than what the remaining bytes can hold; a string has at least
#    its terminator;
#  - encoding: a count must equal the size of its vector.
# Usage: cmake -DIN=raw.hpp -DOUT=safe.hpp -P harden.cmake. Fails when the header has a construct it does not know.
cmake_minimum_required(VERSION 3.25)
file(READ "${IN}" text)

# Arrays whose length is a field.
set(resize "this->([A-Za-z0-9_]+)\\.resize\\(this->([A-Za-z0-9_]+)\\)")
string(REGEX MATCHALL "\\.resize\\(" all_resizes "${text}")
string(REGEX MATCHALL "${resize}" known_resizes "${text}")
list(LENGTH all_resizes all)
list(LENGTH known_resizes known)
if(NOT all EQUAL known)
  message(FATAL_ERROR "${IN}: lcm-gen wrote a resize that harden.cmake does not know; teach it before using this type")
endif()
string(REGEX REPLACE "${resize}"
  "if(this->\\2 < 0 || this->\\2 > (maxlen - pos) / multireach::smallest_encoding(this->\\1)) return -1;\n    this->\\1.resize(this->\\2)"
  text "${text}")

# Strings: members, and elements of arrays of strings.
set(string_check "if\\((__[A-Za-z0-9_]*len[_]*) > maxlen - pos\\)")
string(REGEX MATCHALL "\\.assign\\(" all_strings "${text}")
string(REGEX MATCHALL "${string_check}" known_strings "${text}")
list(LENGTH all_strings all)
list(LENGTH known_strings known)
if(NOT all EQUAL known)
  message(FATAL_ERROR "${IN}: lcm-gen wrote a string that harden.cmake does not know; teach it before using this type")
endif()
string(REGEX REPLACE "${string_check}" "if(\\1 < 1 || \\1 > maxlen - pos)" text "${text}")

# Encoding: counts agree with vectors.
set(counts "")
foreach(match IN LISTS known_resizes)
  string(REGEX REPLACE "${resize}" "\\1;\\2" pair "${match}")
  list(GET pair 0 array)
  list(GET pair 1 count)
  string(APPEND counts "    if(this->${count} < 0 || this->${array}.size() != (size_t)this->${count}) return -1;\n")
endforeach()
if(counts)
  string(REPLACE "::_encodeNoHash(void *buf, int offset, int maxlen) const\n{\n"
    "::_encodeNoHash(void *buf, int offset, int maxlen) const\n{\n${counts}" text "${text}")
  string(REPLACE "::_getEncodedSizeNoHash() const\n{\n" "::_getEncodedSizeNoHash() const\n{\n${counts}" text "${text}")
  string(REPLACE "#include <lcm/lcm_coretypes.h>" "#include <lcm/lcm_coretypes.h>\n#include \"smallest_encoding.hpp\"" text
    "${text}")
  if(NOT text MATCHES "smallest_encoding.hpp")
    message(FATAL_ERROR "${IN}: where to include smallest_encoding.hpp was not found")
  endif()
endif()
file(WRITE "${OUT}" "${text}")
