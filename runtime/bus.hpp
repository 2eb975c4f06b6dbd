#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <span>
#include <string>
#include <string_view>

#include "runtime/message_gate.hpp"

namespace multireach {

/// Where and how a program talks.
struct BusOptions {
  std::string control_url;
  std::string image_url;   ///< empty: the group that belongs to the control group, see channel::image_url_for
  std::string key_file;    ///< with which messages are signed and checked, see MessageGate; empty: none
  std::string key_policy;  ///< which messages; empty: the default
};

/// Publishes and subscribes on both LCM multicast groups: images on one, everything else on the other. Exceptions are
/// caught before they reach LCM.
class Bus {
 public:
  using Handler = std::function<void(std::string_view channel, std::span<const uint8_t> bytes)>;

  /// Throws InputError when LCM cannot be started on one of the URLs, and for a bad key or policy.
  explicit Bus(const BusOptions& options);
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// An exception thrown by `handler` is logged under `name`.
  void subscribe(std::string_view channel, const std::string& name, Handler handler);
  void publish(std::string_view channel, std::span<const uint8_t> bytes);
  /// Waits up to `timeout_us` for messages, then handles all that have arrived. Stops early when `enough`, called after
  /// each poll, returns true.
  void handle_messages(int64_t timeout_us, const std::function<bool()>& enough);
  /// Calls what handles a message; an exception is logged under `name`.
  static void handle_safely(const std::string& name, std::string_view channel, const std::function<void()>& handle);
  /// What all messages pass.
  MessageGate& gate() { return gate_; }

 private:
  struct Subscription {
    std::string name;
    Handler handler;
    MessageGate* gate;
    void handle(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  };

  lcm::LCM& bus_of(std::string_view channel);

  MessageGate gate_;
  lcm::LCM control_, images_;
  bool hears_control_ = false, hears_images_ = false;  // whether a channel of the group is subscribed to
  std::deque<Subscription> subscriptions_;
};

}  // namespace multireach
