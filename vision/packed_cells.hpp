#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace multireach::vision {

// Cells of 8 bits as numbers of a serialized state: six in each, for a double holds 53 bits exactly.

size_t packed_size(size_t cells);
/// Appends the cells to a state.
void append_packed(std::span<const uint8_t> cells, std::vector<double>& state);
/// Whether `state` is what append_packed() appends for this number of cells.
bool is_packed(std::span<const double> state, size_t cells);
/// Sets the cells from a state that is_packed() accepts.
void unpack(std::span<const double> state, std::span<uint8_t> cells);

}  // namespace multireach::vision
