#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "tools/page/foxglove_hub.hpp"

namespace multireach {
namespace {

using json = nlohmann::ordered_json;

/// What a client gets; its thread writes here.
struct Inbox {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::pair<bool, std::string>> got;

  FoxgloveHub::Write write() {
    return [this](bool binary, const std::string& bytes) {
      const std::lock_guard lock(mutex);
      got.emplace_back(binary, bytes);
      changed.notify_all();
      return true;
    };
  }
  /// Message k; waits for it.
  std::pair<bool, std::string> at(size_t k) {
    std::unique_lock lock(mutex);
    EXPECT_TRUE(changed.wait_for(lock, std::chrono::seconds(20), [&] { return got.size() > k; }));
    return got.size() > k ? got[k] : std::pair(false, std::string());
  }
};

json schema() {
  return {{"type", "object"}};
}

TEST(FoxgloveHub, AdvertisesAndSendsWhatIsSubscribed) {
  Inbox inbox;  // outlives the hub's threads
  FoxgloveHub hub;
  int key = 0;
  EXPECT_FALSE(hub.wants("TARGET", "multireach.target_t", schema)) << "nobody is there";
  ASSERT_TRUE(hub.join(&key, inbox.write()));
  EXPECT_EQ(json::parse(inbox.at(0).second)["op"], "serverInfo");
  EXPECT_FALSE(hub.wants("TARGET", "multireach.target_t", schema));
  const json advertised = json::parse(inbox.at(1).second);
  EXPECT_EQ(advertised["op"], "advertise");
  const json& channel = advertised["channels"][0];
  EXPECT_EQ(channel["topic"], "TARGET");
  EXPECT_EQ(channel["encoding"], "json");
  EXPECT_EQ(json::parse(channel["schema"].get<std::string>()), schema());
  hub.receive(&key, json{{"op", "subscribe"}, {"subscriptions", {{{"id", 258}, {"channelId", channel["id"]}}}}}.dump());
  EXPECT_TRUE(hub.wants("TARGET", "multireach.target_t", schema));
  hub.publish("TARGET", 3, "{}");
  // Operation 1, the subscription's number in 4 bytes, the time in nanoseconds in 8, least significant first.
  EXPECT_EQ(inbox.at(2), std::pair(true, std::string("\x01\x02\x01\0\0\xb8\x0b\0\0\0\0\0\0{}", 15)));
  hub.receive(&key, R"({"op": "unsubscribe", "subscriptionIds": [258]})");
  EXPECT_FALSE(hub.wants("TARGET", "multireach.target_t", schema));
  hub.leave(&key);
  EXPECT_FALSE(hub.watched());
}

TEST(FoxgloveHub, LateClientsGetAllTopicsAndThereIsRoomForAFew) {
  std::array<Inbox, FoxgloveHub::kMaxClients + 1> inbox;
  FoxgloveHub hub;
  ASSERT_TRUE(hub.join(&inbox[0], inbox[0].write()));
  (void)hub.wants("A", "a", schema);
  (void)hub.wants("B", "b", schema);
  for (size_t k = 1; k < FoxgloveHub::kMaxClients; ++k) ASSERT_TRUE(hub.join(&inbox[k], inbox[k].write()));
  EXPECT_EQ(json::parse(inbox[1].at(1).second)["channels"].size(), 2u);
  EXPECT_FALSE(hub.has_room());
  EXPECT_FALSE(hub.join(&inbox.back(), inbox.back().write()));
}

TEST(FoxgloveHub, HostileTextsChangeNothing) {
  Inbox inbox;  // outlives the hub's threads
  FoxgloveHub hub;
  int key = 0;
  ASSERT_TRUE(hub.join(&key, inbox.write()));
  (void)hub.wants("A", "a", schema);
  for (const char* text :
       {"", "{", "[]", "null", R"({"op": 3})", R"({"op": "subscribe"})", R"({"op": "subscribe", "subscriptions": 7})",
        R"({"op": "subscribe", "subscriptions": [1, null, {"id": -1, "channelId": 1}, {"id": 1.5, "channelId": 1},
           {"id": 4294967296, "channelId": 1}, {"id": 1}]})",
        R"({"op": "unsubscribe", "subscriptionIds": ["x", -1, 99999999999]})"}) {
    hub.receive(&key, text);
    EXPECT_FALSE(hub.wants("A", "a", schema)) << text;
  }
  int stranger = 0;
  hub.receive(&stranger, R"({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 1}]})");
  hub.leave(&stranger);
  EXPECT_FALSE(hub.wants("A", "a", schema));
}

TEST(FoxgloveHub, AClientThatTakesNothingLosesTheOldestMessages) {
  std::mutex blocked;
  std::vector<size_t> sizes;
  FoxgloveHub hub;
  int key = 0;
  std::unique_lock lock(blocked);
  ASSERT_TRUE(hub.join(&key, [&](bool binary, const std::string& bytes) {
    const std::lock_guard wait(blocked);
    if (binary) sizes.push_back(bytes.size());
    return true;
  }));
  (void)hub.wants("A", "a", schema);
  hub.receive(&key, R"({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 1}]})");
  constexpr size_t kLarge = 1'000'000;
  for (size_t k = 0; k < 40; ++k) hub.publish("A", 0, std::string(kLarge + k, 'x'));
  lock.unlock();
  hub.publish("A", 0, "last");
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < end) {
    const std::lock_guard wait(blocked);
    if (!sizes.empty() && sizes.back() == 17) break;
  }
  hub.leave(&key);
  ASSERT_FALSE(sizes.empty());
  EXPECT_EQ(sizes.back(), 13 + std::string("last").size());
  EXPECT_LE(sizes.size(), FoxgloveHub::kMaxWaiting / kLarge + 2);
  EXPECT_GE(sizes.size(), FoxgloveHub::kMaxWaiting / kLarge);
}

TEST(FoxgloveHub, AClientThatTookOnlyAPartOfAMessageGetsNoOtherOne) {
  std::atomic<int> tried = 0;
  FoxgloveHub hub;
  int key = 0;
  ASSERT_TRUE(hub.join(&key, [&](bool, const std::string&) { return ++tried < 2; }));
  (void)hub.wants("A", "a", schema);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (hub.receive(&key, "{}") && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  EXPECT_FALSE(hub.receive(&key, "{}")) << "the connection is to be closed";
  (void)hub.wants("B", "a", schema);
  hub.leave(&key);  // waits for its thread
  EXPECT_EQ(tried, 2) << "what was open, then A, of which a part was taken";
}

}  // namespace
}  // namespace multireach
