#pragma once

#include <memory>
#include <string>

#include "camera/node/camera_node.hpp"
#include "camera/node/render_source.hpp"
#include "runtime/log_file.hpp"

namespace multireach::testing {

/// Renders a scene file into the log of a session.
inline void render_session(const std::string& scene, const std::string& path) {
  LogWriter log(path);
  CameraNode camera(std::make_unique<RenderSource>(scene));
  while (!camera.finished()) {
    const auto now = camera.next_tick();
    Outbox out;
    camera.tick(out);
    for (const OutMessage& message : out) log.write(now.value_or(0), message.channel, message.bytes);
  }
  log.close();
}

}  // namespace multireach::testing
