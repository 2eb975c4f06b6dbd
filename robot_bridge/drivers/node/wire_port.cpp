#include "robot_bridge/drivers/node/wire_port.hpp"

#include <utility>

namespace multireach::drivers {

void WirePort::append_inputs(std::vector<std::string_view>& channels) const {
  for (const Link& link : links_) {
    if (link.kind == Link::Kind::kLcm) channels.emplace_back(link.receive);
  }
}

bool WirePort::receive(std::string_view channel, std::span<const uint8_t> bytes, const Time& now, Outbox& out) {
  for (size_t link = 0; link < links_.size(); ++link) {
    if (links_[link].kind != Link::Kind::kLcm || links_[link].receive != channel) continue;
    WireOutbox wire;
    end_->receive(link, bytes, now, wire);
    send(wire, now, out);
    return true;
  }
  return false;
}

void WirePort::tick(const Time& now, Outbox& out) {
  WireOutbox wire;
  for (size_t link = 0; link < links_.size(); ++link) {
    if (!transports_[link]) continue;
    if (!up_[link]) {
      if (!transports_[link]->open(now.us)) continue;
      up_[link] = true;
      end_->link_changed(link, true, now, wire);
      send(wire, now, out);
    }
    buffer_.clear();
    const bool open = transports_[link]->receive(buffer_);
    if (!buffer_.empty()) {
      end_->receive(link, buffer_, now, wire);
      send(wire, now, out);
    }
    if (!open && up_[link]) lose(link, now, out);
  }
  end_->tick(now, wire);
  send(wire, now, out);
}

void WirePort::send(WireOutbox& wire, const Time& now, Outbox& out) {
  for (WireBytes& message : std::exchange(wire, {})) {
    const size_t link = message.link;
    if (!transports_[link]) {
      out.push_back({links_[link].send, std::move(message.bytes)});
    } else if (up_[link] && (message.close || !transports_[link]->send(message.bytes))) {
      lose(link, now, out);
    }
  }
}

void WirePort::lose(size_t link, const Time& now, Outbox& out) {
  transports_[link]->close();
  up_[link] = false;
  WireOutbox wire;
  end_->link_changed(link, false, now, wire);
  send(wire, now, out);
}

}  // namespace multireach::drivers
