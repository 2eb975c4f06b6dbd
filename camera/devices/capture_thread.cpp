#include "camera/devices/capture_thread.hpp"

#include <spdlog/spdlog.h>

#include "runtime/files.hpp"

namespace multireach {
namespace {

constexpr int64_t kGrabTimeout = 100000;        // us; bounds the time until a stop request is noticed
constexpr int64_t kReopenPeriod = 500000;       // us
constexpr int64_t kLongWithoutImage = 1000000;  // us; plus two frame periods
constexpr int64_t kWarningPeriod = 5000000;     // us

}  // namespace

CaptureThread::CaptureThread(const Camera& camera, const CaptureClock& clock, StereoBuffer& buffer)
    : camera_(camera),
      clock_(clock),
      buffer_(buffer),
      converter_(camera.form),
      opened_us_(monotonic_us()),
      image_us_(opened_us_) {
  OpenedDevice opened = camera_.open(camera_.name, camera_.request);
  if (!opened.device) throw InputError(opened.fault);
  for (const std::string& remark : opened.remarks) spdlog::warn("{}", remark);
  device_ = std::move(opened.device);
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

std::vector<Side> CaptureThread::sides() const {
  return camera_.both ? std::vector{Side::kLeft, Side::kRight} : std::vector{camera_.side};
}

std::string CaptureThread::label() const {
  const char* side = camera_.both ? "" : camera_.side == Side::kLeft ? "left " : "right ";
  return std::string(side) + "camera " + camera_.name;
}

/// Handles a lost image: logs it at most every kWarningPeriod; NODE_STATUS shows the fault once no image has arrived
/// for long.
void CaptureThread::report_lost_image(const std::string& damage) {
  damage_ = damage;
  const int64_t now = monotonic_us();
  if (last_warning_us_ != 0 && now - last_warning_us_ < kWarningPeriod) return;
  last_warning_us_ = now;
  spdlog::warn("{} {}", label(), damage);
}

void CaptureThread::set_fault(const std::string& fault) {
  if (fault == fault_) return;
  fault_ = fault;
  const std::string sentence = label() + " " + fault;
  for (const Side side : sides()) buffer_.set_fault(side, fault.empty() ? "" : sentence);
  if (fault.empty()) {
    spdlog::info("{} gives images", label());
  } else {
    spdlog::warn("{}", sentence);
  }
}

void CaptureThread::lock_when_due() {
  const std::optional<double>& after = camera_.request.lock_after_s;
  if (locked_ || !after || static_cast<double>(monotonic_us() - opened_us_) < 1e6 * *after) return;
  locked_ = true;
  for (const std::string& remark : device_->lock()) spdlog::info("{}", remark);
}

void CaptureThread::run(const std::stop_token& stop) {
  try {
    while (!stop.stop_requested() && !ended_) {
      if (device_) {
        grab();
      } else {
        reopen(stop);
      }
    }
  } catch (const std::exception& error) {
    buffer_.fail(label() + " cannot go on: " + error.what());
  } catch (...) {
    buffer_.fail(label() + " cannot go on, for an unknown reason");
  }
  if (!ended_) return;
  for (const Side side : sides()) buffer_.end(side);
}

void CaptureThread::grab() {
  if (device_->waits_for_reader() && !buffer_.wait_for_room(camera_.side, kGrabTimeout)) return;
  Grab grab = device_->grab(kGrabTimeout);
  switch (grab.kind) {
    case Grab::Kind::kImage:
      deliver(std::move(grab.image));
      lock_when_due();
      break;
    case Grab::Kind::kDamaged:
      report_lost_image(grab.reason);
      break;
    case Grab::Kind::kReconnecting:
    case Grab::Kind::kDisconnected:
      if (grab.kind == Grab::Kind::kDisconnected) device_.reset();
      damage_.clear();
      for (const Side side : sides()) buffer_.reset(side);
      set_fault(grab.reason + ", trying again");
      return;
    case Grab::Kind::kEndOfStream:
      spdlog::warn("{} gives no more images", label());
      ended_ = true;
      return;
    case Grab::Kind::kNoImage:
      break;
  }
  if (monotonic_us() - image_us_ < kLongWithoutImage + 2000000 / camera_.request.rate_hz) return;
  if (!damage_.empty()) {
    set_fault(damage_);
  } else if (fault_.empty()) {
    set_fault("gives no images");
  }
}

void CaptureThread::reopen(const std::stop_token& stop) {
  for (int64_t waited = 0; waited < kReopenPeriod && !stop.stop_requested(); waited += kGrabTimeout) {
    std::this_thread::sleep_for(std::chrono::microseconds(kGrabTimeout));
  }
  if (stop.stop_requested()) return;
  OpenedDevice opened = camera_.open(camera_.name, camera_.request);
  device_ = std::move(opened.device);
  if (!device_ && !opened.absent) set_fault("was not opened again (" + opened.fault + "), trying again");
  if (!device_) return;
  image_us_ = opened_us_ = monotonic_us();
  locked_ = false;
  damage_.clear();
  for (const std::string& remark : opened.remarks) spdlog::warn("{}", remark);
}

void CaptureThread::deliver(RawImage image) {
  const int64_t utime = clock_.utime_at(image.monotonic_us);
  auto made = converter_.convert(std::move(image), utime);
  if (const auto* damage = std::get_if<std::string>(&made)) return report_lost_image(*damage);
  image_us_ = monotonic_us();
  damage_.clear();
  set_fault("");
  auto& frames = std::get<std::vector<Frame>>(made);
  for (size_t i = 0; i < frames.size(); ++i) buffer_.push(sides()[i], std::move(frames[i]));
}

}  // namespace multireach
