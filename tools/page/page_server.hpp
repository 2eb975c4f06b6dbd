#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/page/access.hpp"
#include "tools/page/browsers.hpp"
#include "tools/page/foxglove_hub.hpp"
#include "tools/page/page_answer.hpp"

namespace multireach {

/// Serves the files of the page over HTTP, and messages over a WebSocket at /messages: text to the browser as JSON,
/// pictures as a byte of Outgoing::Kind and a JPEG; text from the browser as requests. Each browser has a thread of its
/// own that writes to it.
class PageServer : public Browsers {
 public:
  struct Options {
    std::string folder{};               ///< of the page's files
    std::string address = "127.0.0.1";  ///< to listen at
    int port = 0;                       ///< 0: any that is free
    int socket = -1;                    ///< listen at this socket, which another program has opened
    Access access{};
    std::string greeting{};  ///< the first text that a browser gets
    /// Answers questions at /log/, several at a time. Only who knows the token may ask.
    std::function<PageAnswer(std::string_view path, std::string_view query)> answer{};
    FoxgloveHub* foxglove = nullptr;  ///< served at /foxglove?token=...; null: not served
  };
  static constexpr size_t kMaxBrowsers = 8;
  static constexpr size_t kMaxRequests = 64;       ///< that wait for the node
  static constexpr size_t kLongestRequest = 4096;  ///< bytes

  /// Throws InputError when the port cannot be listened at.
  explicit PageServer(Options options);
  ~PageServer() override;
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  int port() const;
  int count() const override;
  bool take_needs_all() override;
  void send(Outgoing::Kind kind, std::string bytes) override;
  std::vector<std::string> take_requests() override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace multireach
