#pragma once

#include <memory>
#include <multireach/images_t.hpp>
#include <multireach/target_t.hpp>
#include <optional>

#include "camera/pairing/frame.hpp"
#include "runtime/node.hpp"

namespace multireach {

struct StereoPair {
  int64_t utime = 0;
  Frame left, right;
  std::optional<target_t> truth;  ///< true position of the object, from a rendered scene
};

/// A source of stereo pairs.
class CameraSource {
 public:
  virtual ~CameraSource() = default;
  /// The next pair. Nothing at the end, or while no pair has arrived yet; `waiting` distinguishes the two.
  virtual std::optional<StereoPair> next() = 0;
  /// Whether more pairs may come after `next` returned nothing.
  virtual bool waiting() const { return false; }
  /// Time at which the next pair is due, microseconds.
  virtual int64_t next_utime() const = 0;
  virtual int64_t period_us() const = 0;
  /// Leaves out so many pairs; only called for a source whose pairs are made when they are asked for.
  virtual void skip(int64_t) {}
  /// For NODE_STATUS.
  virtual std::string state() const { return "running"; }
};

/// Publishes the pairs of a source as STEREO_IMAGES, with the pair's number as metadata "sequence", and TARGET_TRUTH
/// where known.
class CameraNode : public Node {
 public:
  /// `late`: kSkip leaves out pairs that are late by a period or more, as a camera does; only for a source that can
  /// skip.
  explicit CameraNode(std::unique_ptr<CameraSource> source, LateTicks late = LateTicks::kCompute)
      : source_(std::move(source)), late_(late) {}

  std::string name() const override { return "camera"; }
  std::vector<std::string_view> inputs() const override { return {}; }
  Receipt receive(std::string_view, std::span<const uint8_t>, Outbox&) override { return {}; }
  std::optional<int64_t> next_tick() const override;
  int64_t tick_period_us() const override { return source_->period_us(); }
  void tick(Outbox& out) override;
  LateTicks late_ticks() const override { return late_; }
  void skip_ticks(int64_t ticks) override { source_->skip(ticks); }
  bool finished() const override { return finished_; }
  std::string state() const override { return finished_ ? "finished" : source_->state(); }

 private:
  std::unique_ptr<CameraSource> source_;
  LateTicks late_;
  int64_t sequence_ = 0;
  bool finished_ = false;
};

}  // namespace multireach
