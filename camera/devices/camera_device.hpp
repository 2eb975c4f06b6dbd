#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "imaging/image_codec.hpp"

namespace multireach {

/// Requested camera settings.
struct DeviceRequest {
  enum class Format { kAuto, kMjpg, kYuyv };

  int width = 0, height = 0;  ///< of the device's whole image, pixels; 0 for any
  int64_t rate_hz = 30;
  Format format = Format::kAuto;
  /// Each is set to manual at the given value, or left automatic when not given.
  std::optional<double> exposure_ms{}, white_balance_k{}, gain{};
  std::optional<double> lock_after_s{};  ///< time when automatic settings are locked at their current values
  int64_t start_us = 0;                  ///< start of a video file's playback, monotonic clock
};

/// An image as the device delivered it.
struct RawImage {
  int64_t monotonic_us = 0;  ///< time of capture
  int width = 0, height = 0, row_stride = 0;
  PixelFormat format = PixelFormat::kMjpeg;
  std::vector<uint8_t> data{};
};

/// The result of waiting for an image.
struct Grab {
  enum class Kind {
    kImage,
    kNoImage,       ///< no image yet
    kDamaged,       ///< an image was lost; the next may be good
    kReconnecting,  ///< the device disappeared; this object reconnects by itself
    kDisconnected,  ///< the device disappeared or does not answer: it must be reopened
    kEndOfStream,   ///< no more images will come
  };
  Kind kind = Kind::kNoImage;
  RawImage image{};
  std::string reason{};  ///< for kDamaged, kReconnecting, kDisconnected; a predicate without subject ("gave ...")
};

/// A source of images, used by one thread only.
class CameraDevice {
 public:
  virtual ~CameraDevice() = default;
  /// Waits at most `timeout_us` for the next image.
  virtual Grab grab(int64_t timeout_us) = 0;
  /// Locks exposure, gain and white balance at the values that the automatic control has now. Returns a sentence for
  /// each.
  virtual std::vector<std::string> lock() { return {}; }
  /// Whether the source waits for the reader, so that a slow reader loses no image.
  virtual bool waits_for_reader() const { return false; }
};

/// An opened device, or the reason why it could not be opened.
struct OpenedDevice {
  std::unique_ptr<CameraDevice> device;  ///< null on failure
  std::string fault{};                   ///< a sentence beginning with the device's name
  bool absent = false;                   ///< the fault is that no such device exists
  std::vector<std::string> remarks{};    ///< a sentence for each setting that the device refused
};

/// Opens a device by name: a number N for /dev/videoN, the path of a V4L2 device (or a link to one, as in
/// /dev/v4l/by-id), a FIFO with JPEG images, or a video file.
OpenedDevice open_device(const std::string& name, const DeviceRequest& request);

}  // namespace multireach
