#pragma once

#include <span>
#include <vector>

#include "python/arrays.hpp"
#include "runtime/message_schema.hpp"

namespace multireach::python {

/// A message as an object of the Python class of its type; arrays of numbers become NumPy arrays, and byte arrays views
/// into the message, which `owner` keeps alive (None: they are copied). None when the type is unknown or the message
/// malformed.
py::object decoded(std::span<const uint8_t> message, const py::object& owner);

/// The bytes of a message object. Counts follow from the lengths of the arrays. Throws std::invalid_argument that names
/// the field.
std::vector<uint8_t> encoded(const py::object& message);

/// Numbers of a kind, big-endian in a message, in this machine's order.
py::dtype dtype_of(MessageSchema::Kind kind);
size_t size_of(MessageSchema::Kind kind);
/// Copies `count` numbers and turns the order of their bytes.
void turn_bytes(const uint8_t* from, uint8_t* to, size_t count, size_t size);
/// Text, with replacement characters for bytes that are not valid UTF-8.
py::object text_of(std::span<const uint8_t> bytes);

}  // namespace multireach::python
