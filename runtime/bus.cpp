#include "runtime/bus.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>

#include "runtime/channels.hpp"
#include "runtime/files.hpp"

namespace multireach {
namespace {

/// Enlarges the kernel's receive buffer: the default one drops most messages of a raw image stream.
std::string with_receive_buffer(const std::string& url) {
  if (!url.starts_with("udpm://") || url.find("recv_buf_size") != std::string::npos) return url;
  return url + (url.find('?') == std::string::npos ? "?" : "&") + "recv_buf_size=4194304";
}

std::string image_url_of(const BusOptions& options) {
  return options.image_url.empty() ? channel::image_url_for(options.control_url) : options.image_url;
}

void require_good(lcm::LCM& bus, const std::string& url) {
  if (bus.good()) return;
  throw InputError(
      "LCM cannot be started on '" + url +
      "'; without a network, multicast needs a route:  ip link set lo up; ip route add 224.0.0.0/4 dev lo");
}

}  // namespace

Bus::Bus(const BusOptions& options)
    : gate_(options.key_file, options.key_policy),
      control_(with_receive_buffer(options.control_url)),
      images_(with_receive_buffer(image_url_of(options))) {
  require_good(control_, options.control_url);
  require_good(images_, image_url_of(options));
}

lcm::LCM& Bus::bus_of(std::string_view channel) {
  return channel::on_image_group(channel) ? images_ : control_;
}

void Bus::handle_safely(const std::string& name, std::string_view channel, const std::function<void()>& handle) {
  try {
    handle();
  } catch (const std::exception& error) {
    spdlog::error("{}: a message on {} could not be handled: {}", name, channel, error.what());
  }
}

void Bus::Subscription::handle(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
  // An exception must not leave an LCM handler: the next handle() would abort.
  handle_safely(name, channel, [&] {
    const auto payload = gate->incoming(channel, {static_cast<const uint8_t*>(buffer->data), buffer->data_size});
    if (payload) handler(channel, *payload);
  });
}

void Bus::subscribe(std::string_view channel, const std::string& name, Handler handler) {
  subscriptions_.push_back({name, std::move(handler), &gate_});
  (channel::on_image_group(channel) ? hears_images_ : hears_control_) = true;
  bus_of(channel)
      .subscribe(std::string(channel), &Subscription::handle, &subscriptions_.back())
      ->setQueueCapacity(1000);
}

void Bus::publish(std::string_view channel, std::span<const uint8_t> bytes) {
  gate_.outgoing(channel, bytes, [&](std::span<const uint8_t> sent) {
    bus_of(channel).publish(std::string(channel), sent.data(), static_cast<unsigned>(sent.size()));
  });
}

void Bus::handle_messages(int64_t timeout_us, const std::function<bool()>& enough) {
  // Asked for its descriptor, LCM joins the group and starts a thread that wakes for each of its packets.
  std::array<pollfd, 2> fds{
      {{hears_control_ ? control_.getFileno() : -1, POLLIN, 0}, {hears_images_ ? images_.getFileno() : -1, POLLIN, 0}}};
  timeout_us = std::max<int64_t>(timeout_us, 0);
  timespec timeout{timeout_us / 1000000, timeout_us % 1000000 * 1000};
  while (ppoll(fds.data(), fds.size(), &timeout, nullptr) > 0) {
    if (fds[0].revents) control_.handle();
    if (fds[1].revents) images_.handle();
    timeout = {0, 0};
    if (enough()) break;
  }
}

}  // namespace multireach
