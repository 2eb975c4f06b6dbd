#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "imaging/image_codec.hpp"

namespace multireach {

/// What a camera is asked for.
struct DeviceRequest {
  enum class Format { kAuto, kMjpg, kYuyv };

  int width = 0, height = 0;  ///< of the whole image that the device gives, pixels; 0 for any
  int64_t rate_hz = 30;
  Format format = Format::kAuto;
  /// Each is left to the camera's own automatic when not given, and locked when it is.
  std::optional<double> exposure_ms{}, white_balance_k{}, gain{};
  std::optional<double> lock_after_s{};  ///< when what is still automatic is locked as it is then
  int64_t start_us = 0;                  ///< when a video file begins to play, monotonic clock
};

/// An image as the device gave it.
struct RawImage {
  int64_t monotonic_us = 0;  ///< when it was captured
  int width = 0, height = 0, row_stride = 0;
  PixelFormat format = PixelFormat::kMjpeg;
  std::vector<uint8_t> data{};
};

/// What waiting for an image came to.
struct Grab {
  enum class Kind {
    kImage,
    kNothing,  ///< not yet
    kDamaged,  ///< an image was lost; the next may be whole
    kAway,     ///< as kGone, but this object waits for it by itself
    kGone,     ///< the device is there no longer, or does not answer: it has to be opened again
    kEnded,    ///< there will be no more images, ever
  };
  Kind kind = Kind::kNothing;
  RawImage image{};
  std::string reason{};  ///< of kDamaged, kAway and kGone; goes on from "it"
};

/// Something that gives images. One thread uses it.
class CameraDevice {
 public:
  virtual ~CameraDevice() = default;
  /// Waits at most `timeout_us` for the next image.
  virtual Grab grab(int64_t timeout_us) = 0;
  /// Keeps exposure, gain and white balance as the camera's automatic has them now. Returns a sentence for each.
  virtual std::vector<std::string> lock() { return {}; }
  /// Whether it waits for the reader, so that no image need be lost when the reader is slow.
  virtual bool patient() const { return false; }
};

/// A device that was opened, or why it could not be.
struct OpenedDevice {
  std::unique_ptr<CameraDevice> device;  ///< null when it could not be opened
  std::string fault{};                   ///< a sentence that begins with the device's name
  bool absent = false;                   ///< the fault is that there is nothing of this name
  std::vector<std::string> remarks{};    ///< what the device did not accept, a sentence each
};

/// Opens a device by name: a number N for /dev/videoN, the path of a V4L2 device (or a link to one, as in
/// /dev/v4l/by-id), a FIFO that JPEG images come through, or a video file.
OpenedDevice open_device(const std::string& name, const DeviceRequest& request);

}  // namespace multireach
