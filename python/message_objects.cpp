#include "python/message_objects.hpp"

#include <algorithm>
#include <cstring>

#include "runtime/message_walk.hpp"
#include "runtime/schema_texts.hpp"

namespace multireach::python {
namespace {

using Kind = MessageSchema::Kind;
using Field = MessageSchema::Field;

/// The Python class of each type, by its name; filled by multireach/messages.py. Never freed: the interpreter ends
/// first.
py::dict& classes() {
  static auto* dict = new py::dict();
  return *dict;
}

/// Builds the objects of a message while MessageWalk reads it.
class ObjectSink {
 public:
  ObjectSink(const MessageSchema& schema, const py::object& owner) : schema_(schema), owner_(owner) {}
  py::object result() const { return result_; }

  void begin_struct(const Field* field) {
    const py::handle type = classes()[py::str(field ? field->schema->name : schema_.name)];
    stack_.push_back({type.attr("__new__")(type), field ? &field->name : nullptr, false});
  }
  void end_struct() { leave(); }
  void name_array(const std::string& name) { array_name_ = &name; }
  void begin_array(size_t) { stack_.push_back({py::list(), array_name_, true}); }
  void end_array() {
    // Rows of numbers are one array.
    py::list list = stack_.back().object;
    if (!list.empty() && py::isinstance<py::array>(list[0])) stack_.back().object = stack(list);
    leave();
  }
  void values(const Field& field, std::span<const uint8_t> bytes, size_t count) {
    put(field.name, value(field, bytes, count));
  }

 private:
  struct Level {
    py::object object;
    const std::string* name;  // in the level above
    bool list;
  };

  static py::object stack(const py::list& rows) { return py::module_::import("numpy").attr("stack")(rows); }
  py::object value(const Field& field, std::span<const uint8_t> bytes, size_t count) const {
    if (field.kind == Kind::kString) return text_of(bytes);
    if (field.dimensions.empty()) {
      switch (field.kind) {
        case Kind::kBoolean:
          return py::bool_(bytes[0] != 0);
        case Kind::kByte:
          return py::int_(bytes[0]);
        case Kind::kFloat:
        case Kind::kDouble:
          break;
        default:
          return py::int_(integer_in(field.kind, bytes));
      }
      double number = 0;
      float narrow = 0;
      if (field.kind == Kind::kDouble)
        turn_bytes(bytes.data(), reinterpret_cast<uint8_t*>(&number), 1, 8);
      else
        turn_bytes(bytes.data(), reinterpret_cast<uint8_t*>(&narrow), 1, 4);
      return py::float_(field.kind == Kind::kDouble ? number : narrow);
    }
    if (field.kind == Kind::kByte && !owner_.is_none()) {
      py::array_t<uint8_t> view(static_cast<py::ssize_t>(count), bytes.data(), owner_);
      view.attr("flags").attr("writeable") = false;
      return view;
    }
    py::array array(dtype_of(field.kind), static_cast<py::ssize_t>(count));
    turn_bytes(bytes.data(), static_cast<uint8_t*>(array.mutable_data()), count, size_of(field.kind));
    return array;
  }
  void put(const std::string& name, py::object value) {
    Level& level = stack_.back();
    if (level.list)
      level.object.cast<py::list>().append(std::move(value));
    else
      py::setattr(level.object, name.c_str(), value);
  }
  void leave() {
    const Level level = std::move(stack_.back());
    stack_.pop_back();
    if (stack_.empty())
      result_ = level.object;
    else
      put(*level.name, level.object);
  }

  const MessageSchema& schema_;
  const py::object& owner_;
  std::vector<Level> stack_;
  const std::string* array_name_ = nullptr;
  py::object result_ = py::none();
};

void append_big_endian(std::vector<uint8_t>& out, const void* from, size_t count, size_t size) {
  const size_t at = out.size();
  out.resize(at + count * size);
  turn_bytes(static_cast<const uint8_t*>(from), out.data() + at, count, size);
}

class Encoder {
 public:
  std::vector<uint8_t> bytes;

  void message(const MessageSchema& schema, const py::handle& object) {
    append_big_endian(bytes, &schema.fingerprint, 1, 8);
    fields(schema, object);
  }

 private:
  using Counts = std::vector<int64_t>;

  [[noreturn]] static void fail(const MessageSchema& schema, const Field& field, const std::string& what) {
    throw std::invalid_argument(schema.name + "." + field.name + ": " + what);
  }

  void fields(const MessageSchema& schema, const py::handle& object) {
    Counts counts(schema.fields.size(), -1);
    for (const Field& field : schema.fields) measure(schema, field, 0, object.attr(field.name.c_str()), counts);
    for (size_t i = 0; i < schema.fields.size(); ++i) {
      const Field& field = schema.fields[i];
      if (counts[i] >= 0)
        append_integer(schema, field, counts[i]);
      else
        put(schema, field, 0, object.attr(field.name.c_str()));
    }
  }

  /// Notes the counts that follow from the lengths of arrays, and refuses lengths that differ.
  static void measure(const MessageSchema& schema, const Field& field, size_t depth, const py::handle& value,
                      Counts& counts) {
    if (depth == field.dimensions.size()) return;
    const MessageSchema::Dimension& dimension = field.dimensions[depth];
    const auto length = static_cast<int64_t>(py::len(value));
    int64_t fixed = static_cast<int64_t>(dimension.size);
    int64_t& expected = dimension.field < 0 ? fixed : counts[static_cast<size_t>(dimension.field)];
    if (dimension.field >= 0 && expected < 0) expected = length;
    if (length != expected)
      fail(schema, field,
           "has " + std::to_string(length) + " elements; expected " + std::to_string(expected) +
               (dimension.field < 0 ? "" : " (" + dimension.text + ", as another array has)"));
    if (depth + 1 < field.dimensions.size()) {
      for (const py::handle& each : value) measure(schema, field, depth + 1, each, counts);
    }
  }

  void put(const MessageSchema& schema, const Field& field, size_t depth, const py::handle& value) {
    const bool plain = field.kind != Kind::kString && field.kind != Kind::kStruct;
    try {
      if (depth < field.dimensions.size() && (!plain || depth + 1 < field.dimensions.size())) {
        for (const py::handle& each : value) put(schema, field, depth + 1, each);
      } else if (field.kind == Kind::kStruct) {
        fields(*field.schema, value);
      } else if (field.kind == Kind::kString) {
        const auto text = value.cast<std::string>();
        if (text.find('\0') != std::string::npos) fail(schema, field, "a text must not hold a zero");
        const auto length = static_cast<int32_t>(text.size() + 1);
        append_big_endian(bytes, &length, 1, 4);
        bytes.insert(bytes.end(), text.c_str(), text.c_str() + text.size() + 1);
      } else if (depth == field.dimensions.size()) {
        number(schema, field, value);
      } else {
        numbers(schema, field, value);
      }
    } catch (const py::cast_error&) {
      fail(schema, field, "'" + py::repr(value).cast<std::string>() + "' is not a " + field.type);
    }
  }

  void number(const MessageSchema& schema, const Field& field, const py::handle& value) {
    if (field.kind == Kind::kDouble || field.kind == Kind::kFloat) {
      const auto wide = value.cast<double>();
      const auto narrow = static_cast<float>(wide);
      if (field.kind == Kind::kDouble)
        append_big_endian(bytes, &wide, 1, 8);
      else
        append_big_endian(bytes, &narrow, 1, 4);
    } else if (field.kind == Kind::kBoolean) {
      bytes.push_back(value.cast<bool>() ? 1 : 0);
    } else {
      append_integer(schema, field, value.cast<int64_t>());
    }
  }
  void append_integer(const MessageSchema& schema, const Field& field, int64_t value) {
    const size_t size = size_of(field.kind);
    const bool is_byte = field.kind == Kind::kByte;
    const int64_t most = is_byte ? 255 : size == 8 ? INT64_MAX : (int64_t{1} << (8 * size - 1)) - 1;
    if (value > most || value < (is_byte ? 0 : -most - 1))
      fail(schema, field, std::to_string(value) + " is not a " + field.type);
    append_big_endian(bytes, &value, 1, size);  // little-endian machine: the lower bytes come first
  }
  void numbers(const MessageSchema& schema, const Field& field, const py::handle& value) {
    if (py::isinstance<py::array>(value)) {
      const auto given = py::reinterpret_borrow<py::array>(value);
      if (given.ndim() == 1 && given.dtype().is(dtype_of(field.kind)) && (given.flags() & py::array::c_style)) {
        append_big_endian(bytes, given.data(), static_cast<size_t>(given.size()), size_of(field.kind));
        return;
      }
    }
    // As NumPy converts, but never from floating point to integers.
    const py::object array = py::module_::import("numpy").attr("ascontiguousarray")(value);
    if (array.attr("ndim").cast<int>() != 1) fail(schema, field, "has more dimensions than its definition");
    const py::array turned =
        array.attr("astype")(dtype_of(field.kind), "C", py::len(array) == 0 ? "unsafe" : "same_kind");
    append_big_endian(bytes, turned.data(), static_cast<size_t>(turned.size()), size_of(field.kind));
  }
};

const MessageSchema& schema_named(const std::string& name) {
  static const std::map<std::string, const MessageSchema*> kSchemas = [] {
    std::map<std::string, const MessageSchema*> schemas;
    for (const MessageSchema* schema : MessageSchemas::project().all()) schemas[schema->name] = schema;
    return schemas;
  }();
  const auto at = kSchemas.find(name);
  if (at == kSchemas.end()) throw std::invalid_argument("'" + name + "' is no message of multireach");
  return *at->second;
}

}  // namespace

py::dtype dtype_of(Kind kind) {
  switch (kind) {
    case Kind::kBoolean:
      return py::dtype::of<bool>();
    case Kind::kByte:
      return py::dtype::of<uint8_t>();
    case Kind::kInt8:
      return py::dtype::of<int8_t>();
    case Kind::kInt16:
      return py::dtype::of<int16_t>();
    case Kind::kInt32:
      return py::dtype::of<int32_t>();
    case Kind::kInt64:
      return py::dtype::of<int64_t>();
    case Kind::kFloat:
      return py::dtype::of<float>();
    default:
      return py::dtype::of<double>();
  }
}

size_t size_of(Kind kind) {
  return kind == Kind::kString || kind == Kind::kStruct ? 1 : static_cast<size_t>(dtype_of(kind).itemsize());
}

void turn_bytes(const uint8_t* from, uint8_t* to, size_t count, size_t size) {
  if (size == 1) {
    if (count > 0) std::memcpy(to, from, count);
    return;
  }
  for (size_t i = 0; i < count; ++i, from += size, to += size) std::reverse_copy(from, from + size, to);
}

py::object text_of(std::span<const uint8_t> bytes) {
  return py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(reinterpret_cast<const char*>(bytes.data()),
                                                                static_cast<py::ssize_t>(bytes.size()), "replace"));
}

py::object decoded(std::span<const uint8_t> message, const py::object& owner) {
  const MessageSchema* schema = MessageSchemas::project().of(message);
  if (!schema || !well_formed(*schema, message)) return py::none();
  ObjectSink sink(*schema, owner);
  MessageWalk<ObjectSink> walk(message, sink);
  return walk.parse(*schema) ? sink.result() : py::none();
}

std::vector<uint8_t> encoded(const py::object& message) {
  Encoder encoder;
  encoder.message(schema_named(py::type::of(message).attr("__name__").cast<std::string>()), message);
  return std::move(encoder.bytes);
}

void bind_messages(py::module_& module) {
  module.attr("message_classes") = classes();
  module.attr("message_texts") = py::cast(std::vector<std::string>(kSchemaTexts.begin(), kSchemaTexts.end()));
  module.def("message_fields", [](const std::string& name) {
    py::list fields;
    for (const Field& field : schema_named(name).fields) {
      py::list dimensions;
      for (const auto& dimension : field.dimensions) dimensions.append(dimension.text);
      fields.append(py::make_tuple(field.name, field.type, dimensions));
    }
    return fields;
  });
  module.def(
      "decode",
      [](const py::buffer& data) {
        const py::buffer_info info = data.request();
        if (info.ndim != 1 || info.itemsize != 1) throw std::invalid_argument("decode: expected bytes");
        return decoded({static_cast<const uint8_t*>(info.ptr), static_cast<size_t>(info.size)}, data);
      },
      py::arg("data"), "The message that the bytes hold; None when they are not exactly one well-formed message.");
  module.def(
      "encode",
      [](const py::object& message) {
        const std::vector<uint8_t> bytes = encoded(message);
        return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      },
      py::arg("message"), "The bytes of a message. Counts, such as num_joints, follow from the lengths of the arrays.");
}

}  // namespace multireach::python
