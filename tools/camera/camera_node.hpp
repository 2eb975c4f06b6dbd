#pragma once

#include <memory>
#include <multireach/images_t.hpp>
#include <multireach/target_t.hpp>
#include <optional>

#include "runtime/node.hpp"

namespace multireach {

/// One image as it goes on the wire.
struct Frame {
  int64_t utime = 0;
  int width = 0, height = 0;
  int row_stride = 0;
  int32_t pixelformat = 0;
  std::vector<uint8_t> data;
};

struct StereoPair {
  int64_t utime = 0;
  Frame left, right;
  std::optional<target_t> truth;  ///< where the object really is, from a source that knows
};

/// Where pairs come from.
class CameraSource {
 public:
  virtual ~CameraSource() = default;
  /// The next pair, or nothing at the end. Its time is at least that of `next_utime`.
  virtual std::optional<StereoPair> next() = 0;
  /// When the next pair is due, microseconds.
  virtual int64_t next_utime() const = 0;
  virtual int64_t period_us() const = 0;
};

/// A source as a node: STEREO_IMAGES out, with the number of the pair as metadata "sequence", and TARGET_TRUTH where
/// known.
class CameraNode : public Node {
 public:
  explicit CameraNode(std::unique_ptr<CameraSource> source) : source_(std::move(source)) {}

  std::string name() const override { return "camera"; }
  std::vector<std::string_view> inputs() const override { return {}; }
  Receipt receive(std::string_view, std::span<const uint8_t>, Outbox&) override { return {}; }
  std::optional<int64_t> next_tick() const override;
  int64_t tick_period_us() const override { return source_->period_us(); }
  void tick(Outbox& out) override;
  bool finished() const override { return finished_; }
  std::string state() const override { return finished_ ? "finished" : "running"; }

 private:
  std::unique_ptr<CameraSource> source_;
  int64_t sequence_ = 0;
  bool finished_ = false;
};

}  // namespace multireach
