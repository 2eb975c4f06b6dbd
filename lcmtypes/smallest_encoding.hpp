#pragma once

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace multireach {

/// Fewest bytes that one element of `array` takes on the wire. The hardened decoders divide the remaining bytes by it
/// before they allocate, so a message can never make a receiver allocate more than its own bytes could fill.
template <class Element>
int smallest_encoding(const std::vector<Element>&) {
  if constexpr (std::is_arithmetic_v<Element>) {
    return sizeof(Element);
  } else if constexpr (std::is_same_v<Element, std::string>) {
    return 5;  // an int32 length and the terminator
  } else {
    static const int kSize = Element()._getEncodedSizeNoHash();
    return kSize;
  }
}

}  // namespace multireach
