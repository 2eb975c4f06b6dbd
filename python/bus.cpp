#include "runtime/bus.hpp"

#include <chrono>
#include <cstdlib>

#include "python/message_objects.hpp"
#include "runtime/channels.hpp"
#include "runtime/datagram_guard.hpp"

namespace multireach::python {
namespace {

/// Delivers messages to Python. LCM must not see exceptions: the first one of a handler is kept, and raised by
/// handle().
class PythonBus {
 public:
  PythonBus(const std::optional<std::string>& control, const std::string& images, const std::optional<std::string>& key,
            const std::optional<std::string>& key_policy)
      : bus_({.control_url = control.value_or(environment("LCM_DEFAULT_URL", channel::kControlUrl)),
              .image_url = images,
              .key_file = key.value_or(environment("MULTIREACH_KEY", "")),
              .key_policy = key_policy.value_or(environment("MULTIREACH_KEY_POLICY", ""))}) {}

  void publish(const std::string& channel, const py::object& message) {
    if (py::isinstance<py::bytes>(message)) {
      const auto bytes = message.cast<std::string>();
      send(channel, {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
    } else {
      send(channel, encoded(message));
    }
  }

  void subscribe(const std::string& channel, const py::function& handler) {
    bus_.subscribe(channel, "python", [this, handler](std::string_view at, std::span<const uint8_t> bytes) {
      const py::gil_scoped_acquire acquire;
      if (failure_) return;
      try {
        const py::object message = decoded(bytes, py::none());
        if (message.is_none())
          ++malformed_;
        else
          handler(py::str(at.data(), at.size()), message);
        ++handled_;
      } catch (...) {
        failure_ = std::current_exception();
      }
    });
  }

  int64_t handle(double timeout_s) {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::microseconds kSlice{50000};  // between two looks for Ctrl-C
    const auto end =
        Clock::now() + std::chrono::microseconds(static_cast<int64_t>(std::clamp(timeout_s, 0.0, 1e9) * 1e6));
    const int64_t before = handled_;
    do {
      const auto left = std::chrono::duration_cast<std::chrono::microseconds>(end - Clock::now());
      {
        const py::gil_scoped_release release;
        bus_.handle_messages(std::min(left, kSlice).count(), [this] { return failure_ != nullptr; });
      }
      if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    } while (handled_ == before && Clock::now() < end);
    return handled_ - before;
  }

  int64_t malformed() const { return malformed_; }
  int64_t refused() { return bus_.gate().total_refused(); }

 private:
  static std::string environment(const char* variable, std::string_view otherwise) {
    const char* value = std::getenv(variable);
    return value && *value ? value : std::string(otherwise);
  }
  void send(const std::string& channel, std::span<const uint8_t> bytes) {
    const py::gil_scoped_release release;
    bus_.publish(channel, bytes);
  }

  Bus bus_;
  std::exception_ptr failure_;
  int64_t handled_ = 0, malformed_ = 0;
};

}  // namespace

void bind_bus(py::module_& module) {
  py::class_<PythonBus>(module, "Bus",
                        R"(Publishes and subscribes on both LCM groups: images on one, everything else on the other.

control_url: default LCM_DEFAULT_URL of the environment, else the programs' group; image_url: default the group that belongs
to it. key: the key file with which messages are signed and checked, default MULTIREACH_KEY of the environment, else none;
key_policy: which messages, default MULTIREACH_KEY_POLICY, else all of multireach. Malformed datagrams are dropped before LCM sees them, as in the programs. InputError: LCM cannot be started, or the key cannot be
used.)")
      .def(py::init<const std::optional<std::string>&, const std::string&, const std::optional<std::string>&,
                    const std::optional<std::string>&>(),
           py::arg("control_url") = py::none(), py::arg("image_url") = "", py::arg("key") = py::none(),
           py::arg("key_policy") = py::none())
      .def("publish", &PythonBus::publish, py::arg("channel"), py::arg("message"),
           "Sends a message of multireach.messages, or bytes.")
      .def("subscribe", &PythonBus::subscribe, py::arg("channel"), py::arg("handler"),
           "handle() will call handler(channel, message) for each well-formed message of the channel.")
      .def("handle", &PythonBus::handle, py::arg("timeout_s"),
           R"(Waits for messages at most this long, then handles all that have arrived.

Returns their number. An exception of a handler is raised here.)")
      .def_property_readonly("malformed", &PythonBus::malformed, "Number of messages that were not well-formed.")
      .def_property_readonly("refused", &PythonBus::refused, "Number of messages refused because of their signature.");
  module.def("dropped_datagrams", &dropped_datagrams,
             "Number of malformed datagrams that were dropped before LCM saw them.");
}

}  // namespace multireach::python
