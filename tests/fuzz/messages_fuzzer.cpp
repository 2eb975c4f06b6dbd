// Any bytes as a message of every type: what a decoder accepts, it encodes again with the same size, or not at all
// where a text holds a zero, at which LCM ends it.
#include <cstdlib>
#include <multireach/all_types.hpp>

#include "runtime/message.hpp"
#include "runtime/message_schema.hpp"

namespace multireach {
namespace {

template <class... Types>
struct EachType {
  static void decode_and_encode(std::span<const uint8_t> bytes) { (one<Types>(bytes), ...); }

 private:
  template <class Message>
  static void one(std::span<const uint8_t> bytes) {
    const auto message = decode<Message>(bytes);
    if (!message) return;
    const auto again = encode(*message);
    if (again && again->size() != bytes.size()) std::abort();
  }
};

}  // namespace
}  // namespace multireach

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace multireach;
  // The first byte chooses a type, whose fingerprint the fuzzer would hardly find.
  if (size < 1) return 0;
  static const auto types = MessageSchemas::project().all();
  const MessageSchema& schema = *types[data[0] % types.size()];
  std::vector<uint8_t> bytes(8 + size - 1);
  for (size_t i = 0; i < 8; ++i)
    bytes[i] = static_cast<uint8_t>(static_cast<uint64_t>(schema.fingerprint) >> (56 - 8 * i));
  std::copy(data + 1, data + size, bytes.begin() + 8);
  AllTypes<EachType>::decode_and_encode(bytes);
  const bool whole = well_formed(schema, bytes);
  if (whole != leaves_of(schema, bytes).has_value() || whole != json_of(schema, bytes).has_value()) std::abort();
  sequence_of(schema, bytes);
  return 0;
}
