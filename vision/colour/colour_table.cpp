#include "vision/colour/colour_table.hpp"

#include <bit>
#include <limits>

#include "vision/colour/chroma_classifier.hpp"

namespace multireach::vision {
namespace {

constexpr int kCodes = 32, kNibbles = 16;

/// The first value of each interval, and 256 at the end.
constexpr std::array<int, kCodes + 1> interval_begins() {
  std::array<int, kCodes + 1> begins{};
  for (int code = 1; code < kCodes; ++code) {
    begins[static_cast<size_t>(code)] = (code * code * kClipped + 31 * 31 - 1) / (31 * 31);
  }
  begins[kCodes] = 256;
  // At the dark end every interval has at least one value.
  for (int code = 1; code < kCodes; ++code) {
    const auto k = static_cast<size_t>(code);
    if (begins[k] <= begins[k - 1]) begins[k] = begins[k - 1] + 1;
  }
  return begins;
}
constexpr auto kBegins = interval_begins();
static_assert(kBegins[31] == kClipped);

constexpr double middle_of(int code) {
  const auto k = static_cast<size_t>(code);
  return code == kCodes - 1 ? kClipped : 0.5 * (kBegins[k] + kBegins[k + 1] - 1);
}

/// One bit for each nibble (upper four bits of a channel) that an interval overlaps.
constexpr uint32_t nibbles_of(int code) {
  const auto k = static_cast<size_t>(code);
  const int first = kBegins[k] >> 4, last = (kBegins[k + 1] - 1) >> 4;
  return ((2U << last) - 1) & ~((1U << first) - 1);
}

/// For each nibble of one channel, the nibbles of the other two channels that occur with it.
struct Slabs {
  std::array<uint32_t, kNibbles> second{}, third{};
};

}  // namespace

ColourTable::ColourTable() {
  for (size_t code = 0; code < kCodes; ++code) {
    for (int value = kBegins[code]; value < kBegins[code + 1]; ++value) {
      code_[static_cast<size_t>(value)] = static_cast<uint8_t>(code);
    }
  }
}

ColourTable::ColourTable(const ColourModel& model, const WhiteBalanceGains& gains)
    : ColourTable(ChromaClassifier(model, gains)) {}

ColourTable::ColourTable(const ChromaClassifier& test) : ColourTable() {
  std::array<double, kCodes> middles;
  for (int code = 0; code < kCodes; ++code) middles[static_cast<size_t>(code)] = middle_of(code);
  for (size_t r = 0; r < kCodes; ++r) {
    for (size_t g = 0; g < kCodes; ++g) rows_[r << 5 | g] = test.contains(middles[r], middles[g], middles);
  }
  find_boxes();
}

void ColourTable::find_boxes() {
  // Divide one channel into eight slabs of two nibbles each; each slab gives a box. Use the channel whose boxes have
  // the smallest total volume.
  std::array<Slabs, 3> slabs;  // along red, green, blue
  for (int r = 0; r < kCodes; ++r) {
    for (int g = 0; g < kCodes; ++g) {
      const uint32_t row = rows_[static_cast<size_t>(r) << 5 | static_cast<size_t>(g)];
      if (row == 0) continue;
      uint32_t blue = 0;
      for (uint32_t bits = row; bits != 0; bits &= bits - 1) blue |= nibbles_of(std::countr_zero(bits));
      const uint32_t red = nibbles_of(r), green = nibbles_of(g);
      for (size_t nibble = 0; nibble < kNibbles; ++nibble) {
        if (red >> nibble & 1) {
          slabs[0].second[nibble] |= green;
          slabs[0].third[nibble] |= blue;
        }
        if (green >> nibble & 1) {
          slabs[1].second[nibble] |= blue;
          slabs[1].third[nibble] |= red;
        }
        if (blue >> nibble & 1) {
          slabs[2].second[nibble] |= red;
          slabs[2].third[nibble] |= green;
        }
      }
    }
  }
  int smallest = std::numeric_limits<int>::max();
  for (size_t axis = 0; axis < 3; ++axis) {
    ColourBoxes boxes;
    const std::array<std::array<uint8_t, 16>*, 3> channels{&boxes.red, &boxes.green, &boxes.blue};
    auto &along = *channels[axis], &second = *channels[(axis + 1) % 3], &third = *channels[(axis + 2) % 3];
    int volume = 0;
    for (size_t box = 0; box < 8; ++box) {
      const uint32_t in_second = slabs[axis].second[2 * box] | slabs[axis].second[2 * box + 1];
      const uint32_t in_third = slabs[axis].third[2 * box] | slabs[axis].third[2 * box + 1];
      const auto bit = static_cast<uint8_t>(1U << box);
      int long_side = 0;
      for (size_t nibble = 0; nibble < kNibbles; ++nibble) {
        if (nibble / 2 == box && slabs[axis].second[nibble] != 0) {
          along[nibble] |= bit;
          ++long_side;
        }
        if (in_second >> nibble & 1) second[nibble] |= bit;
        if (in_third >> nibble & 1) third[nibble] |= bit;
      }
      volume += long_side * std::popcount(in_second) * std::popcount(in_third);
    }
    if (volume >= smallest) continue;
    smallest = volume;
    boxes_ = boxes;
  }
}

}  // namespace multireach::vision
