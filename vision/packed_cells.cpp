#include "vision/packed_cells.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::vision {
namespace {

constexpr size_t kPerNumber = 6;
constexpr double kBase = 256;

}  // namespace

size_t packed_size(size_t cells) {
  return (cells + kPerNumber - 1) / kPerNumber;
}

void append_packed(std::span<const uint8_t> cells, std::vector<double>& state) {
  for (size_t first = 0; first < cells.size(); first += kPerNumber) {
    double number = 0;
    for (size_t k = std::min(first + kPerNumber, cells.size()); k-- > first;) number = number * kBase + cells[k];
    state.push_back(number);
  }
}

bool is_packed(std::span<const double> state, size_t cells) {
  if (state.size() != packed_size(cells)) return false;
  for (size_t k = 0; k < state.size(); ++k) {
    const double in_this = static_cast<double>(std::min(kPerNumber, cells - k * kPerNumber));
    if (!(state[k] >= 0 && state[k] < std::pow(kBase, in_this) && state[k] == std::floor(state[k]))) return false;
  }
  return true;
}

void unpack(std::span<const double> state, std::span<uint8_t> cells) {
  for (size_t first = 0; first < cells.size(); first += kPerNumber) {
    auto number = static_cast<uint64_t>(state[first / kPerNumber]);
    for (size_t k = first; k < std::min(first + kPerNumber, cells.size()); ++k, number >>= 8)
      cells[k] = static_cast<uint8_t>(number & 0xff);
  }
}

}  // namespace multireach::vision
