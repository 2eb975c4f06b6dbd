#pragma once

#include "runtime/node.hpp"

namespace multireach {

/// Requests vision's debug picture once a second and keeps the newest one in a file.
class PictureNode : public Node {
 public:
  /// `path`: the JPEG file, replaced by each complete new picture. `origin_utime`: time of the first request,
  /// microseconds.
  PictureNode(std::string path, int64_t origin_utime) : path_(std::move(path)), next_tick_us_(origin_utime) {}

  std::string name() const override { return "view"; }
  std::vector<std::string_view> inputs() const override;
  /// Refuses messages that are not exactly one JPEG image.
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> next_tick() const override { return next_tick_us_; }
  int64_t tick_period_us() const override { return kPeriodUs; }
  /// Throws InputError when the file cannot be written.
  void tick(Outbox& out) override;
  std::string state() const override { return pictures_ > 0 ? "receiving pictures" : "asking for a picture"; }

  /// Writes the newest picture unless already written. Throws InputError.
  void flush();
  int64_t pictures() const { return pictures_; }

 private:
  static constexpr int64_t kPeriodUs = 250000;  // between two writes of the file
  static constexpr int kTicksPerRequest = 4;

  std::string path_;
  int64_t next_tick_us_;
  int ticks_ = 0;
  std::vector<uint8_t> unwritten_;
  int64_t pictures_ = 0;
};

}  // namespace multireach
