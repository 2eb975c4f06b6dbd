#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>

#include "python/message_objects.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message_walk.hpp"

namespace multireach::python {
namespace {

using Kind = MessageSchema::Kind;
using Field = MessageSchema::Field;
using Path = std::filesystem::path;

/// One value of all messages of a channel.
struct Column {
  const Field* field;
  std::vector<uint8_t> numbers;
  std::vector<py::object> texts;
  std::vector<size_t> ends;  // of each message's values, counted in values

  size_t count() const { return field->kind == Kind::kString ? texts.size() : numbers.size() / size_of(field->kind); }
  void close(size_t messages) { ends.resize(messages, count()); }
};

/// Collects the columns of one channel. Structs in arrays have their index in the name, as "images[0].utime".
class ColumnSink {
 public:
  explicit ColumnSink(const std::optional<std::vector<std::string>>& wanted) : wanted_(wanted) {}

  void begin_struct(const Field* field) {
    outer_.push_back(prefix_);
    if (!field) return;
    prefix_ += field->name;
    if (!field->dimensions.empty()) prefix_ += indices_.back();
    prefix_ += ".";
  }
  void end_struct() {
    prefix_ = outer_.back();
    outer_.pop_back();
  }
  void begin_array(size_t) { indices_.emplace_back(); }
  void end_array() { indices_.pop_back(); }
  void begin_element(size_t index) { indices_.back() = "[" + std::to_string(index) + "]"; }
  void values(const Field& field, std::span<const uint8_t> bytes, size_t count) {
    const bool bulky = field.kind == Kind::kByte && !field.dimensions.empty();
    const std::string name = prefix_ + field.name;
    if (wanted_ ? std::ranges::find(*wanted_, name) == wanted_->end() : bulky) return;
    const auto [at, is_new] = columns_.try_emplace(name, Column{&field, {}, {}, {}});
    Column& column = at->second;
    if (is_new) order_.push_back(name);
    column.close(messages_);
    if (field.kind == Kind::kString) {
      column.texts.push_back(text_of(bytes));
      return;
    }
    const size_t size = size_of(field.kind), old = column.numbers.size();
    column.numbers.resize(old + count * size);
    turn_bytes(bytes.data(), column.numbers.data() + old, count, size);
  }
  void end_message() {
    ++messages_;
    for (auto& [name, column] : columns_) column.close(messages_);
  }

  py::dict result() const {
    py::dict result;
    for (const std::string& name : order_) result[py::str(name)] = array_of_column(columns_.at(name));
    return result;
  }

 private:
  py::object array_of_column(const Column& column) const {
    size_t per_message = messages_ ? column.ends[0] : 0;
    bool equal = true;
    for (size_t i = 1; i < messages_; ++i) equal = equal && column.ends[i] - column.ends[i - 1] == per_message;
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(messages_)};
    const auto& dimensions = column.field->dimensions;
    const bool fixed = std::ranges::all_of(dimensions, [](const auto& dimension) { return dimension.field < 0; });
    for (const auto& dimension : dimensions)
      if (fixed) shape.push_back(static_cast<py::ssize_t>(dimension.size));
    if (!fixed) shape.push_back(static_cast<py::ssize_t>(per_message));
    const py::module_ numpy = py::module_::import("numpy");
    if (equal) return slice(column, 0, column.count()).attr("reshape")(shape);
    // The messages have different numbers of values: an array of arrays.
    py::object rows = numpy.attr("empty")(messages_, "object");
    for (size_t i = 0; i < messages_; ++i)
      rows[py::int_(i)] = slice(column, i ? column.ends[i - 1] : 0, column.ends[i]);
    return rows;
  }
  static py::object slice(const Column& column, size_t from, size_t to) {
    if (column.field->kind == Kind::kString) {
      py::list texts;
      for (size_t i = from; i < to; ++i) texts.append(column.texts[i]);
      return py::module_::import("numpy").attr("array")(texts, "str");
    }
    py::array array(dtype_of(column.field->kind), static_cast<py::ssize_t>(to - from));
    const size_t size = size_of(column.field->kind);
    std::copy_n(column.numbers.data() + from * size, (to - from) * size, static_cast<uint8_t*>(array.mutable_data()));
    return array;
  }

  const std::optional<std::vector<std::string>>& wanted_;
  std::map<std::string, Column> columns_;
  std::vector<std::string> order_, outer_, indices_;
  std::string prefix_;
  size_t messages_ = 0;
};

struct Log {
  std::string path;
};

struct Event {
  py::object owner;  // keeps the file mapped
  LogEvent event;

  py::array_t<uint8_t> data() const {
    py::array_t<uint8_t> view(static_cast<py::ssize_t>(event.data.size()), event.data.data(), owner);
    view.attr("flags").attr("writeable") = false;
    return view;
  }
};

/// Reads on its own, so that several iterators of one log do not disturb each other.
struct Iterator {
  std::shared_ptr<LogReader> reader;
  py::object owner;
  std::vector<std::string> channels;

  Iterator(const Log& log, std::vector<std::string> some)
      : reader(std::make_shared<LogReader>(log.path)), channels(std::move(some)) {
    owner = py::capsule(new std::shared_ptr<LogReader>(reader),
                        [](void* kept) { delete static_cast<std::shared_ptr<LogReader>*>(kept); });
  }
  Event next() {
    while (const auto event = reader->next()) {
      if (channels.empty() || std::ranges::find(channels, event->channel) != channels.end()) return {owner, *event};
    }
    throw py::stop_iteration();
  }
};

py::dict columns(const Log& log, const std::string& channel, const std::optional<std::vector<std::string>>& fields) {
  LogReader reader(log.path);
  ColumnSink sink(fields);
  std::vector<int64_t> times;
  int64_t malformed = 0;
  const MessageSchema* type = nullptr;
  while (const auto event = reader.next()) {
    if (event->channel != channel) continue;
    const MessageSchema* schema = MessageSchemas::project().of(event->data);
    if (!schema || !well_formed(*schema, event->data) || (type && schema != type)) {
      ++malformed;
      continue;
    }
    type = schema;
    MessageWalk<ColumnSink>(event->data, sink).parse(*schema);
    sink.end_message();
    times.push_back(event->utime);
  }
  if (times.empty() && malformed == 0) throw py::key_error(log.path + ": no message on channel '" + channel + "'");
  if (malformed > 0)
    PyErr_WarnFormat(PyExc_RuntimeWarning, 1, "%s: %lld messages on %s are damaged or of another type, and left out",
                     log.path.c_str(), static_cast<long long>(malformed), channel.c_str());
  if (PyErr_Occurred()) throw py::error_already_set();
  py::dict result = sink.result();
  if (!fields || std::ranges::find(*fields, "log_utime") != fields->end())
    result["log_utime"] = py::array_t<int64_t>(static_cast<py::ssize_t>(times.size()), times.data());
  return result;
}

}  // namespace

void bind_logs(py::module_& module) {
  py::class_<Event>(module, "LogEvent", "One message of a log.")
      .def_property_readonly("number", [](const Event& event) { return event.event.number; })
      .def_property_readonly(
          "utime", [](const Event& event) { return event.event.utime; },
          "Time of receipt by the logger, wall clock, microseconds.")
      .def_property_readonly("channel", [](const Event& event) { return std::string(event.event.channel); })
      .def_property_readonly("data", &Event::data, "The message's bytes: a read-only view of the file.")
      .def_property_readonly(
          "message", [](const Event& event) { return decoded(event.event.data, event.owner); },
          "The message as an object of multireach.messages; None when it is malformed or unknown.");
  py::class_<Iterator>(module, "LogIterator")
      .def("__iter__", [](Iterator& self) -> Iterator& { return self; })
      .def("__next__", &Iterator::next);
  py::class_<Log>(module, "Log", R"(A log of lcm-logger; iterating over it gives its LogEvents in order.

Damaged parts are skipped. Raises InputError when the file cannot be read or holds no event.)")
      .def(py::init([](const Path& path) {
             const LogReader readable(path.string());
             return Log{path.string()};
           }),
           py::arg("path"))
      .def_readonly("path", &Log::path)
      .def("__iter__", [](const Log& log) { return Iterator(log, {}); })
      .def(
          "events",
          [](const Log& log, std::vector<std::string> channels) { return Iterator(log, std::move(channels)); },
          py::arg("channels") = std::vector<std::string>{},
          "Iterates over the events of these channels; of all for none.")
      .def("columns", &columns, py::arg("channel"), py::arg("fields") = py::none(),
           R"(All messages of a channel as arrays, by field: {"utime": (messages,), "position_m": (messages, 3), ...}.

Fields of structs are named as "images[0].utime". "log_utime" is the time of receipt. Where messages have different numbers
of values, the column is an array of arrays. Byte arrays are left out unless `fields` names them. KeyError: no such channel.)")
      .def(
          "channels",
          [](const Log& log) {
            LogReader reader(log.path);
            std::map<std::string, int64_t> counts;
            while (const auto event = reader.next()) ++counts[std::string(event->channel)];
            return counts;
          },
          "The number of messages on each channel.");
}

}  // namespace multireach::python
