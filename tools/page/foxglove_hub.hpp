#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace multireach {

/// The server's side of Foxglove's WebSocket protocol, version 1
/// (https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md): topics are advertised, and sent to the clients
/// that subscribe to them. Clients only read. Safe for several threads; no call waits for a client, but `leave`.
class FoxgloveHub {
 public:
  static constexpr const char* kSubprotocol = "foxglove.websocket.v1";
  static constexpr size_t kMaxClients = 4;
  static constexpr size_t kMaxTopics = 200;
  static constexpr size_t kMaxSubscriptions = 500;   ///< of one client
  static constexpr size_t kMaxWaiting = 16'000'000;  ///< bytes for one client; the oldest messages are dropped

  /// Writes a text or binary message; false where that is not possible any more.
  using Write = std::function<bool(bool binary, const std::string& bytes)>;

  FoxgloveHub() = default;
  ~FoxgloveHub();
  FoxgloveHub(const FoxgloveHub&) = delete;
  FoxgloveHub& operator=(const FoxgloveHub&) = delete;

  /// A connection is open: a thread of its own writes to it. False where there are too many.
  bool join(const void* client, Write write);
  void leave(const void* client);
  bool has_room() const;
  /// A text of a client: subscribes or unsubscribes; others change nothing. False where nothing can be written to it
  /// any more.
  bool receive(const void* client, std::string_view text);

  /// Whether any client is connected.
  bool watched() const;
  /// Whether any client has subscribed to the topic. Advertises it where it is new.
  bool wants(const std::string& topic, const std::string& schema_name,
             const std::function<nlohmann::ordered_json()>& schema);
  /// Sends a message, JSON, to all who subscribed. `utime`: microseconds.
  void publish(const std::string& topic, int64_t utime, const std::string& text);

 private:
  struct Topic {
    uint32_t id = 0;
    nlohmann::ordered_json advertised;
  };
  struct Client {
    std::map<uint32_t, uint32_t> topic_of;  // by the client's number of the subscription
    std::deque<std::pair<bool, std::string>> waiting;
    size_t waiting_bytes = 0;
    bool closed = false;
    bool lost = false;  // a message could not be written
    std::thread writer;
  };

  void queue(Client& client, bool binary, std::string bytes);
  void write_to(Client& client, const Write& write);
  static void subscribe(Client& client, const nlohmann::json& subscriptions);

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Topic> topics_;
  std::map<const void*, std::unique_ptr<Client>> clients_;
};

}  // namespace multireach
