#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <span>
#include <string>
#include <string_view>

namespace multireach {

/// Publishes and subscribes on both LCM multicast groups: images on one, everything else on the other. Exceptions are
/// caught before they reach LCM.
class Bus {
 public:
  using Handler = std::function<void(std::string_view channel, std::span<const uint8_t> bytes)>;

  /// An empty `image_url` is the one that belongs to `control_url`, see channel::image_url_for. Throws InputError when
  /// LCM cannot be started on one of the URLs.
  Bus(const std::string& control_url, const std::string& image_url);
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// An exception thrown by `handler` is logged under `name`.
  void subscribe(std::string_view channel, const std::string& name, Handler handler);
  void publish(std::string_view channel, std::span<const uint8_t> bytes);
  /// Waits up to `timeout_us` for messages, then handles all that have arrived. Stops early when `enough`, called after
  /// each poll, returns true.
  void handle_messages(int64_t timeout_us, const std::function<bool()>& enough);

 private:
  struct Subscription {
    std::string name;
    Handler handler;
    void handle(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  };

  lcm::LCM& bus_of(std::string_view channel);

  lcm::LCM control_, images_;
  bool hears_control_ = false, hears_images_ = false;  // whether a channel of the group is subscribed to
  std::deque<Subscription> subscriptions_;
};

}  // namespace multireach
