#pragma once

#include <span>
#include <vector>

#include "vision/colour/blob.hpp"
#include "vision/colour/pixel_class.hpp"
#include "vision/colour/row_opening.hpp"

namespace multireach::vision {

struct FindOptions {
  double min_area = 30;  ///< pixels; smaller blobs are left out
  int most = 8;          ///< blobs that are returned, at least 1
  /// Without specks and bridges of less than three pixels: the opening of the class's pixels by a cross of five.
  bool opened = true;
};

/// What one part of an image shows of a colour.
struct Found {
  std::span<const Blob> blobs;  ///< the largest first; of equal ones the one that begins in an earlier row, then column
  int64_t members = 0;          ///< pixels of the class, also those that are in no blob
  bool crowded = false;         ///< more than kMostRuns runs: the colour is all over the place; `blobs` is empty
};
/// More runs than this are no image of an object: one on every second pixel of a full VGA image is 153 600.
inline constexpr size_t kMostRuns = 1 << 16;

/// Finds the blobs of a class of colours: its pixels, with those that touch at a side or a corner together. Keeps its
/// memory from image to image, so each thread has its own.
class Finder {
 public:
  /// In `part` of an 8-bit BGR image; what of the part is outside of the image is ignored. The answer's blobs stay
  /// until the next call.
  Found find(const cv::Mat& bgr, const cv::Rect& part, const PixelClass& colours, const FindOptions& options = {});

 private:
  /// The pixels of a set of runs, added up; places relative to the part.
  struct Sums {
    int64_t area = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    int left = 0, top = 0, right = 0, bottom = 0;  // right and bottom are beyond the last pixel
    void add(const Run& run);
    void add(const Sums& other);
  };

  bool gather_runs(const cv::Mat& bgr, const cv::Rect& part, const PixelClass& colours, bool opened, int64_t& members);
  void cut_row(const uint64_t* bits, int row, int width);
  void connect_row(size_t above, size_t row);
  uint32_t root_of(uint32_t label);
  void join(uint32_t a, uint32_t b);
  void rank(const FindOptions& options);
  void fill_blobs(const cv::Point& corner);

  RowOpening opening_;
  std::vector<Run> runs_;         // relative to the part
  std::vector<uint32_t> label_;   // of each run
  std::vector<uint32_t> parent_;  // of each label; roots are their own
  std::vector<Sums> sums_;        // of each label; those of a whole set with its root
  std::vector<uint32_t> ranked_;  // labels of the blobs, in order
  std::vector<int32_t> place_;    // of each label's blob in the answer, or -1
  std::vector<Blob> blobs_;       // as many as were ever needed, so that their runs keep their memory
};

}  // namespace multireach::vision
