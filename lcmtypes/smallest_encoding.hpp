#pragma once

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace multireach {

/// The smallest encoded size of one element of the array, bytes. Before allocating an array, the hardened decoders
/// compare its length with the remaining bytes divided by this size. So a message cannot make a receiver allocate more
/// elements than its own bytes could hold.
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
