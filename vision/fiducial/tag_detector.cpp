#include "vision/fiducial/tag_detector.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace multireach::vision {
namespace {

constexpr int kSmallestWindow = 24;  // pixels; the smallest tag that can be decoded is about that large

struct FamilyDeleter {
  void operator()(apriltag_family_t* family) const { tag36h11_destroy(family); }
};
using Family = std::unique_ptr<apriltag_family_t, FamilyDeleter>;

/// Luma (R + 2G + B)/4 of the part `window`.
void copy_luma(const cv::Mat& bgr, const cv::Rect& window, cv::Mat1b& luma) {
  luma.create(window.size());
  for (int row = 0; row < window.height; ++row) {
    const auto* in = bgr.ptr<cv::Vec3b>(window.y + row) + window.x;
    uint8_t* out = luma.ptr(row);
    for (int column = 0; column < window.width; ++column) {
      const cv::Vec3b& p = in[column];
      out[column] = static_cast<uint8_t>((p[0] + 2 * p[1] + p[2] + 2) / 4);
    }
  }
}

/// Rounded, so that another build of the library, whose last bits differ, gives the same start.
double sixteenths(double value) {
  return std::floor(value * 16 + 0.5) / 16;
}

}  // namespace

struct TagDetector::Library {
  Family family{tag36h11_create()};
  apriltag_detector_t* detector = apriltag_detector_create();
  cv::Mat1b luma;

  Library() {
    apriltag_detector_add_family_bits(detector, family.get(), 1);
    detector->nthreads = 1;
    detector->quad_decimate = 1;
  }
  ~Library() { apriltag_detector_destroy(detector); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
};

TagDetector::TagDetector() : library_(std::make_unique<Library>()) {}
TagDetector::~TagDetector() = default;
TagDetector::TagDetector(TagDetector&&) noexcept = default;
TagDetector& TagDetector::operator=(TagDetector&&) noexcept = default;

std::vector<FoundTag> TagDetector::find(const cv::Mat& bgr, const cv::Rect& window) {
  std::vector<FoundTag> found;
  if (window.width < kSmallestWindow || window.height < kSmallestWindow) return found;
  copy_luma(bgr, window, library_->luma);
  image_u8_t image{library_->luma.cols, library_->luma.rows, static_cast<int32_t>(library_->luma.step),
                   library_->luma.data};
  zarray_t* detections = apriltag_detector_detect(library_->detector, &image);
  for (int k = 0; k < zarray_size(detections); ++k) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(detections, k, static_cast<void*>(&detection));
    FoundTag tag{detection->id, {}};
    for (size_t corner = 0; corner < 4; ++corner) {
      // The library has the centre of the first pixel at (0.5, 0.5).
      tag.corners[corner] = {sixteenths(detection->p[corner][0] - 0.5 + window.x),
                             sixteenths(detection->p[corner][1] - 0.5 + window.y)};
    }
    found.push_back(tag);
  }
  apriltag_detections_destroy(detections);
  std::ranges::sort(found, {},
                    [](const FoundTag& tag) { return std::tuple(tag.id, tag.corners[0].y(), tag.corners[0].x()); });
  return found;
}

cv::Mat1b tag_cells(int id) {
  const Family family(tag36h11_create());
  cv::Mat1b cells(family->total_width, family->total_width, uint8_t{1});
  const int margin = (family->total_width - family->width_at_border) / 2;
  cells(cv::Rect(margin, margin, family->width_at_border, family->width_at_border)) = 0;
  for (uint32_t bit = 0; bit < family->nbits; ++bit) {
    const bool white = family->codes[id] >> (family->nbits - 1 - bit) & 1;
    cells(static_cast<int>(family->bit_y[bit]) + margin, static_cast<int>(family->bit_x[bit]) + margin) = white ? 1 : 0;
  }
  return cells;
}

}  // namespace multireach::vision
