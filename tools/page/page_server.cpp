#include "tools/page/page_server.hpp"

#include <civetweb.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>
#include <utility>

#include "runtime/files.hpp"
#include "tools/page/listening_socket.hpp"

namespace multireach {
namespace {

constexpr const char* kMessages = "/messages";
constexpr const char* kFoxglove = "/foxglove";
constexpr std::string_view kQuestions = "/log/";
constexpr const char* kWriteTimeout = "3000";  // ms: a browser that takes nothing for so long is disconnected
constexpr const char* kPingAfter = "3000";     // ms without a word of a browser; it may leave six unanswered
// Everything comes from this server, and no other page may show this one inside itself.
constexpr const char* kHeaders =
    "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' "
    "blob: data:; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'\r\n"
    "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer";

std::string_view header(const mg_connection* connection, const char* name) {
  const char* value = mg_get_header(connection, name);
  return value ? value : "";
}

int refuse_host(mg_connection* connection) {
  mg_send_http_error(connection, 403, "%s",
                     "This name of the computer is not accepted: use its address, localhost, or --host NAME.");
  return 403;
}

int write_answer(mg_connection* connection, const PageAnswer& answer) {
  const char* phrase = answer.status == 200 ? "OK" : answer.status == 204 ? "No Content" : "Bad Request";
  mg_printf(connection, "HTTP/1.1 %d %s\r\n%s\r\nCache-Control: no-store\r\nConnection: close\r\n", answer.status,
            phrase, kHeaders);
  if (answer.status != 204)
    mg_printf(connection, "Content-Type: %s\r\nContent-Length: %zu\r\n", answer.type.c_str(), answer.body.size());
  mg_printf(connection, "\r\n");
  if (answer.status != 204) mg_write(connection, answer.body.data(), answer.body.size());
  return answer.status;
}

int opcode_of(Outgoing::Kind kind) {
  return kind == Outgoing::Kind::kAnswer || kind == Outgoing::Kind::kFrame ? MG_WEBSOCKET_OPCODE_TEXT
                                                                           : MG_WEBSOCKET_OPCODE_BINARY;
}

bool write_message(mg_connection* connection, int opcode, const std::string& bytes) {
  return mg_websocket_write(connection, opcode, bytes.data(), bytes.size()) >= static_cast<int>(bytes.size());
}

struct Browser {
  mg_connection* connection = nullptr;
  OutgoingQueue queue;
  std::thread writer;
  std::atomic<bool> cut = false;

  /// A browser that did not take all of a message in time would read the next one as the rest of it: it gets no other
  /// one, and is disconnected by the thread that reads from it, with its next request or when it answers no ping. (This
  /// thread must not close the connection: the other one may be reading from it.)
  void write() {
    while (const auto next = queue.pop()) {
      if (write_message(connection, opcode_of(next->kind), *next->bytes)) continue;
      cut = true;
      return;
    }
  }
};

}  // namespace

struct PageServer::State {
  Options options;
  mg_context* server = nullptr;
  int port = 0;
  mutable std::mutex mutex;
  std::vector<std::unique_ptr<Browser>> browsers;
  std::vector<std::string> requests;
  bool joined = false;

  static State& of(void* data) { return *static_cast<State*>(data); }
  static int begin_request(mg_connection* connection);
  static int connect(const mg_connection* connection, void* data);
  static void ready(mg_connection* connection, void* data);
  static int receive(mg_connection* connection, int bits, char* bytes, size_t size, void* data);
  static void close(const mg_connection* connection, void* data);
  void serve_foxglove();
  /// Needs the lock.
  auto browser_of(const mg_connection* connection) {
    return std::ranges::find(browsers, connection, [](const auto& each) { return each->connection; });
  }
};

int PageServer::State::begin_request(mg_connection* connection) {
  const State& state = of(mg_get_user_data(mg_get_context(connection)));
  if (!state.options.access.allows_host(header(connection, "Host"))) return refuse_host(connection);
  const mg_request_info* request = mg_get_request_info(connection);
  const std::string_view path = request->local_uri ? request->local_uri : "";
  if (!state.options.answer || !path.starts_with(kQuestions)) return 0;
  const std::string_view query = request->query_string ? request->query_string : "";
  if (!state.options.access.allows_reading(header(connection, "Host"), query)) {
    mg_send_http_error(connection, 403, "%s", "The token of the page's address is missing or wrong.");
    return 403;
  }
  return write_answer(connection, state.options.answer(path, query));
}

int PageServer::State::connect(const mg_connection* connection, void* data) {
  const State& state = of(data);
  const char* query = mg_get_request_info(connection)->query_string;
  const bool allowed = state.options.access.allows_messages(header(connection, "Host"), header(connection, "Origin"),
                                                            query ? query : "");
  const std::lock_guard lock(state.mutex);
  return allowed && state.browsers.size() < kMaxBrowsers ? 0 : 1;
}

void PageServer::State::ready(mg_connection* connection, void* data) {
  State& state = of(data);
  auto browser = std::make_unique<Browser>();
  browser->connection = connection;
  browser->queue.push({Outgoing::Kind::kAnswer, std::make_shared<const std::string>(state.options.greeting)});
  browser->writer = std::thread([browser = browser.get()] { browser->write(); });
  const std::lock_guard lock(state.mutex);
  state.browsers.push_back(std::move(browser));
  state.joined = true;
}

int PageServer::State::receive(mg_connection* connection, int bits, char* bytes, size_t size, void* data) {
  constexpr int kLast = 0x80, kOpcode = 0x0f;
  const int opcode = bits & kOpcode;
  if (opcode == MG_WEBSOCKET_OPCODE_CONNECTION_CLOSE) return 0;
  if (opcode != MG_WEBSOCKET_OPCODE_TEXT) return 1;
  if (!(bits & kLast) || size > kLongestRequest) return 0;
  State& state = of(data);
  const std::lock_guard lock(state.mutex);
  const auto from = state.browser_of(connection);
  if (from != state.browsers.end() && (*from)->cut) return 0;
  if (state.requests.size() < kMaxRequests) state.requests.emplace_back(bytes, size);
  return 1;
}

void PageServer::State::close(const mg_connection* connection, void* data) {
  State& state = of(data);
  std::unique_ptr<Browser> gone;
  {
    const std::lock_guard lock(state.mutex);
    const auto found = state.browser_of(connection);
    if (found == state.browsers.end()) return;
    gone = std::move(*found);
    state.browsers.erase(found);
  }
  gone->queue.close();
  gone->writer.join();
}

/// Foxglove and Lichtblick may be pages of other sites, or no pages: only the token counts.
void PageServer::State::serve_foxglove() {
  const auto connect = [](const mg_connection* connection, void* data) {
    const State& state = of(data);
    const char* query = mg_get_request_info(connection)->query_string;
    const bool allowed = state.options.access.allows_reading(header(connection, "Host"), query ? query : "");
    return allowed && state.options.foxglove->has_room() ? 0 : 1;
  };
  const auto ready = [](mg_connection* connection, void* data) {
    const auto write = [connection](bool binary, const std::string& bytes) {
      return write_message(connection, binary ? MG_WEBSOCKET_OPCODE_BINARY : MG_WEBSOCKET_OPCODE_TEXT, bytes);
    };
    if (!of(data).options.foxglove->join(connection, write)) mg_close_connection(connection);
  };
  const auto receive = [](mg_connection* connection, int bits, char* bytes, size_t size, void* data) {
    constexpr int kLast = 0x80, kOpcode = 0x0f;
    constexpr size_t kLongest = 65536;
    if ((bits & kOpcode) == MG_WEBSOCKET_OPCODE_CONNECTION_CLOSE || !(bits & kLast) || size > kLongest) return 0;
    if ((bits & kOpcode) != MG_WEBSOCKET_OPCODE_TEXT) return 1;
    return of(data).options.foxglove->receive(connection, {bytes, size}) ? 1 : 0;
  };
  const auto close = [](const mg_connection* connection, void* data) { of(data).options.foxglove->leave(connection); };
  // civetweb keeps the pointers.
  static const char* protocols[] = {FoxgloveHub::kSubprotocol};
  static mg_websocket_subprotocols accepted{1, protocols};
  mg_set_websocket_handler_with_subprotocols(server, kFoxglove, &accepted, connect, ready, receive, close, this);
}

PageServer::PageServer(Options options) : state_(std::make_unique<State>()) {
  state_->options = std::move(options);
  const Options& given = state_->options;
  // A socket that is handed in takes the place of one that civetweb has opened itself: it cannot be told of one.
  const std::string address = given.socket >= 0 ? "127.0.0.1:0" : fmt::format("{}:{}", given.address, given.port);
  const char* settings[] = {"document_root",
                            given.folder.c_str(),
                            "listening_ports",
                            address.c_str(),
                            "num_threads",
                            "24",
                            "enable_directory_listing",
                            "no",
                            "request_timeout_ms",
                            kWriteTimeout,
                            "websocket_timeout_ms",
                            kPingAfter,
                            "enable_websocket_ping_pong",
                            "yes",
                            "static_file_max_age",
                            "0",
                            "additional_header",
                            kHeaders,
                            nullptr};
  mg_init_library(0);
  mg_callbacks callbacks{};
  callbacks.begin_request = &State::begin_request;
  callbacks.log_message = [](const mg_connection*, const char*) { return 1; };
  state_->server = mg_start(&callbacks, state_.get(), settings);
  mg_server_port ports{};
  if (!state_->server || mg_get_server_ports(state_->server, 1, &ports) != 1) {
    if (state_->server) mg_stop(state_->server);
    throw InputError("the page cannot be served at " + address + "; is the port in use, or not of this computer?");
  }
  mg_set_websocket_handler(state_->server, kMessages, &State::connect, &State::ready, &State::receive, &State::close,
                           state_.get());
  if (given.foxglove) state_->serve_foxglove();
  state_->port = ports.port;
  if (given.socket >= 0) state_->port = replace_listening_socket(state_->port, given.socket);
}

PageServer::~PageServer() {
  {
    const std::lock_guard lock(state_->mutex);
    for (const auto& browser : state_->browsers) browser->queue.close();
  }
  mg_stop(state_->server);
  mg_exit_library();
}

int PageServer::port() const {
  return state_->port;
}

int PageServer::count() const {
  const std::lock_guard lock(state_->mutex);
  return static_cast<int>(state_->browsers.size());
}

bool PageServer::take_needs_all() {
  const std::lock_guard lock(state_->mutex);
  bool needed = std::exchange(state_->joined, false);
  for (const auto& browser : state_->browsers) needed |= browser->queue.take_dropped();
  return needed;
}

void PageServer::send(Outgoing::Kind kind, std::string bytes) {
  if (opcode_of(kind) == MG_WEBSOCKET_OPCODE_BINARY) bytes.insert(bytes.begin(), static_cast<char>(kind));
  const auto shared = std::make_shared<const std::string>(std::move(bytes));
  const std::lock_guard lock(state_->mutex);
  for (const auto& browser : state_->browsers) browser->queue.push({kind, shared});
}

std::vector<std::string> PageServer::take_requests() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->requests, {});
}

}  // namespace multireach
