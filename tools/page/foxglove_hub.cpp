#include "tools/page/foxglove_hub.hpp"

#include <algorithm>
#include <array>

#include "runtime/json_text.hpp"

namespace multireach {
namespace {

using json = nlohmann::ordered_json;

void append_little_endian(std::string& bytes, uint64_t value, int count) {
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
}

/// A whole number of 32 bits under `key`.
std::optional<uint32_t> number_in(const nlohmann::json& object, const char* key) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  if (!object.is_object() || found == object.end() || !found->is_number_unsigned()) return std::nullopt;
  const auto value = found->get<uint64_t>();
  return value <= UINT32_MAX ? std::optional(static_cast<uint32_t>(value)) : std::nullopt;
}

}  // namespace

FoxgloveHub::~FoxgloveHub() {
  std::vector<const void*> all;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [key, client] : clients_) all.push_back(key);
  }
  for (const void* client : all) leave(client);
}

bool FoxgloveHub::has_room() const {
  const std::lock_guard lock(mutex_);
  return clients_.size() < kMaxClients;
}

bool FoxgloveHub::watched() const {
  const std::lock_guard lock(mutex_);
  return !clients_.empty();
}

bool FoxgloveHub::join(const void* key, Write write) {
  const std::lock_guard lock(mutex_);
  if (clients_.size() >= kMaxClients || clients_.contains(key)) return false;
  auto client = std::make_unique<Client>();
  queue(*client, false,
        json_text({{"op", "serverInfo"},
                   {"name", "multireach"},
                   {"capabilities", json::array()},
                   {"supportedEncodings", json::array()},
                   {"metadata", json::object()}}));
  json channels = json::array();
  for (const auto& [topic, known] : topics_) channels.push_back(known.advertised);
  if (!channels.empty()) queue(*client, false, json_text({{"op", "advertise"}, {"channels", channels}}));
  client->writer = std::thread([this, client = client.get(), write = std::move(write)] { write_to(*client, write); });
  clients_.emplace(key, std::move(client));
  return true;
}

void FoxgloveHub::leave(const void* key) {
  std::unique_ptr<Client> gone;
  {
    const std::lock_guard lock(mutex_);
    const auto found = clients_.find(key);
    if (found == clients_.end()) return;
    gone = std::move(found->second);
    clients_.erase(found);
    gone->closed = true;
  }
  changed_.notify_all();
  gone->writer.join();
}

void FoxgloveHub::queue(Client& client, bool binary, std::string bytes) {
  if (client.lost) return;
  client.waiting_bytes += bytes.size();
  client.waiting.emplace_back(binary, std::move(bytes));
  // What is text, advertisements, must arrive; of data a client that lags loses the oldest.
  while (client.waiting_bytes > kMaxWaiting) {
    const auto oldest = std::ranges::find_if(client.waiting, [](const auto& each) { return each.first; });
    if (oldest == client.waiting.end()) break;
    client.waiting_bytes -= oldest->second.size();
    client.waiting.erase(oldest);
  }
  changed_.notify_all();
}

void FoxgloveHub::write_to(Client& client, const Write& write) {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return client.closed || !client.waiting.empty(); });
    if (client.closed) return;
    const auto [binary, bytes] = std::move(client.waiting.front());
    client.waiting.pop_front();
    client.waiting_bytes -= bytes.size();
    lock.unlock();
    const bool written = write(binary, bytes);
    lock.lock();
    if (written) continue;
    client.lost = true;
    client.waiting.clear();
    return;
  }
}

void FoxgloveHub::subscribe(Client& client, const nlohmann::json& subscriptions) {
  for (const auto& each : subscriptions) {
    const auto id = number_in(each, "id"), channel = number_in(each, "channelId");
    // A second subscription to a topic would only copy its messages.
    const bool known =
        channel && std::ranges::any_of(client.topic_of, [&](const auto& given) { return given.second == *channel; });
    if (id && channel && !known && client.topic_of.size() < kMaxSubscriptions) client.topic_of[*id] = *channel;
  }
}

bool FoxgloveHub::receive(const void* key, std::string_view text) {
  const auto message = nlohmann::json::parse(text, nullptr, false);
  const std::lock_guard lock(mutex_);
  const auto found = clients_.find(key);
  if (found == clients_.end() || found->second->lost) return false;
  if (!message.is_object()) return true;
  const auto word = message.find("op");
  const auto list = [&](const char* name) {
    const auto value = message.find(name);
    return value != message.end() && value->is_array() ? *value : nlohmann::json::array();
  };
  if (word == message.end() || !word->is_string()) return true;
  if (*word == "subscribe") {
    subscribe(*found->second, list("subscriptions"));
  } else if (*word == "unsubscribe") {
    for (const auto& id : list("subscriptionIds")) {
      if (id.is_number_unsigned() && id.get<uint64_t>() <= UINT32_MAX)
        found->second->topic_of.erase(id.get<uint32_t>());
    }
  }
  return true;
}

bool FoxgloveHub::wants(const std::string& topic, const std::string& schema_name,
                        const std::function<nlohmann::ordered_json()>& schema) {
  const std::lock_guard lock(mutex_);
  if (clients_.empty()) return false;
  auto known = topics_.find(topic);
  if (known == topics_.end()) {
    if (topics_.size() >= kMaxTopics) return false;
    const auto id = static_cast<uint32_t>(topics_.size() + 1);
    const json advertised{{"id", id},
                          {"topic", topic},
                          {"encoding", "json"},
                          {"schemaName", schema_name},
                          {"schema", json_text(schema())},
                          {"schemaEncoding", "jsonschema"}};
    known = topics_.emplace(topic, Topic{id, advertised}).first;
    for (const auto& [key, client] : clients_)
      queue(*client, false, json_text({{"op", "advertise"}, {"channels", json::array({advertised})}}));
  }
  return std::ranges::any_of(clients_, [&](const auto& each) {
    return std::ranges::any_of(each.second->topic_of,
                               [&](const auto& subscribed) { return subscribed.second == known->second.id; });
  });
}

void FoxgloveHub::publish(const std::string& topic, int64_t utime, const std::string& text) {
  constexpr char kMessageData = 0x01;
  const std::lock_guard lock(mutex_);
  const auto known = topics_.find(topic);
  if (known == topics_.end()) return;
  for (const auto& [key, client] : clients_) {
    for (const auto& [subscription, id] : client->topic_of) {
      if (id != known->second.id) continue;
      std::string bytes(1, kMessageData);
      append_little_endian(bytes, subscription, 4);
      append_little_endian(bytes, static_cast<uint64_t>(std::max<int64_t>(utime, 0)) * 1000, 8);
      queue(*client, true, bytes + text);
    }
  }
}

}  // namespace multireach
