#pragma once

#include <span>
#include <vector>

#include "vision/colour/blob.hpp"
#include "vision/colour/colour_table.hpp"
#include "vision/colour/row_opening.hpp"

namespace multireach::vision {

struct BlobFinderOptions {
  double min_area = 30;  ///< pixels; smaller blobs are dropped
  int most = 8;          ///< largest number of blobs returned, at least 1
  /// Morphological opening of the mask by a cross of five pixels; removes specks and bridges narrower than three
  /// pixels.
  bool opened = true;
};

/// Blobs of a colour in one part of an image.
struct FoundBlobs {
  std::span<const Blob> blobs;  ///< by decreasing area; equal areas by the first pixel's row, then column
  int64_t members = 0;          ///< pixels in the mask, including those in no blob
  bool too_many_runs = false;   ///< more than kMaxRuns runs: the colour is everywhere; `blobs` is empty
};
/// An image with more runs does not show an object. For comparison: a run on every second pixel of a VGA image gives
/// 153 600.
inline constexpr size_t kMaxRuns = 1 << 16;

/// Finds the blobs of a colour: 8-connected components of its mask. Reuses memory from image to image, so use one
/// object per thread.
class BlobFinder {
 public:
  /// Searches `part` of an 8-bit BGR image, clipped to the image. The returned blobs are valid until the next call.
  FoundBlobs find(const cv::Mat& bgr, const cv::Rect& part, const ColourTable& colours,
                  const BlobFinderOptions& options = {});

 private:
  /// Sums over the pixels of a set of runs; positions relative to the part.
  struct Sums {
    int64_t area = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    int left = 0, top = 0, right = 0, bottom = 0;  // right and bottom are exclusive
    void add(const Run& run);
    void add(const Sums& other);
  };

  bool gather_runs(const cv::Mat& bgr, const cv::Rect& part, const ColourTable& colours, bool opened, int64_t& members);
  void cut_row(const uint64_t* bits, int row, int width);
  void connect_row(size_t above, size_t row);
  uint32_t root_of(uint32_t label);
  void join(uint32_t a, uint32_t b);
  void rank(const BlobFinderOptions& options);
  void fill_blobs(const cv::Point& corner);

  RowOpening opening_;
  std::vector<Run> runs_;            // relative to the part
  std::vector<uint32_t> label_;      // of each run
  std::vector<uint32_t> parent_;     // of each label (union-find); a root is its own parent
  std::vector<Sums> sums_;           // of each label; the root's holds the whole component
  std::vector<uint32_t> ranked_;     // root labels of the returned blobs, largest first
  std::vector<int32_t> blob_index_;  // index of each label's blob in ranked_, or -1
  std::vector<Blob> blobs_;          // never shrinks, so that the runs keep their memory
};

}  // namespace multireach::vision
