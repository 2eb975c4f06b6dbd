#pragma once

#include "robot_bridge/drivers/driver.hpp"
#include "robot_bridge/drivers/status_filter.hpp"

namespace multireach::drivers {

/// KUKA iiwa through drake-iiwa-driver, with its application for positions: IIWA_STATUS in, IIWA_COMMAND out, one
/// command in each 5 ms. That driver ends when it gets a command within 0.25 s of its first status; it holds the last
/// position indefinitely when commands end; and it reports no fault, but sends no status any more.
class IiwaDriver : public Driver {
 public:
  explicit IiwaDriver(int joints) : joints_(joints), statuses_("IIWA_STATUS", joints) {}

  std::vector<Link> links() const override {
    return {{.kind = Link::Kind::kLcm, .receive = "IIWA_STATUS", .send = "IIWA_COMMAND"}};
  }
  void receive(size_t link, std::span<const uint8_t> bytes, const Time& now, WireOutbox& out) override;
  void tick(const Time& now, WireOutbox& out) override;
  void command(const JointVector& position, const JointVector& velocity, int64_t utime, const Time& now,
               WireOutbox& out) override;
  std::optional<Reading> take_reading() override { return std::exchange(reading_, std::nullopt); }
  DriverStatus status() const override;
  RefusedMessages refused() const override { return {statuses_.refused(), statuses_.text()}; }

 private:
  int joints_;
  StatusFilter statuses_;
  RateDivider divider_{5000};
  std::optional<int64_t> first_status_us_;  // of the present run of drake-iiwa-driver
  int64_t heard_us_ = 0;
  bool warm_ = false;  // the status has its time: the first 200 have none
  bool ready_ = false, was_ready_ = false;
  std::optional<Reading> reading_;
};

}  // namespace multireach::drivers
