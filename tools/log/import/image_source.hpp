#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera/pairing/frame.hpp"
#include "imaging/side.hpp"

namespace multireach {

/// One image of a recording.
struct ListedImage {
  int64_t utime = 0;  ///< time stamp, microseconds
  Side side = Side::kLeft;
  size_t number = 0;  ///< of the image in its source
};

/// The images of two cameras in a recording of another program.
class ImageSource {
 public:
  using Progress = std::function<void(double)>;  ///< called with the part that is done

  virtual ~ImageSource() = default;
  /// All images of both cameras, in any order. Throws InputError.
  virtual std::vector<ListedImage> list(const Progress& progress) = 0;
  /// One of them. Throws InputError when it cannot be read.
  virtual Frame read(const ListedImage& image) = 0;
  /// A sentence on what is missing in the recording although the rest can be used; "" for nothing.
  virtual std::string warning() const { return ""; }
};

/// Which recorded images are those of the two cameras, and how they are stored in the session.
struct ImportOptions {
  std::string input;
  std::string left, right;           ///< topics, or folders of an EuRoC recording; "" for its cam0 and cam1
  std::optional<double> max_skew_s;  ///< between the images of a pair; default: half the period of the images
  int jpeg_quality = 95;             ///< of images that are not JPEG; 0: raw
};

/// Opens a folder with pairs.csv or of EuRoC, a ROS bag, or an MCAP file. Throws InputError.
std::unique_ptr<ImageSource> open_image_source(const ImportOptions& options);

std::unique_ptr<ImageSource> open_pairs_folder(const ImportOptions& options);
std::unique_ptr<ImageSource> open_euroc_folder(const ImportOptions& options);

}  // namespace multireach
