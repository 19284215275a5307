#include "daemon/control/control_server.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <system_error>
#include <variant>

#include "daemon/system/nearest_word.hpp"

namespace contourd {
namespace {

using Json = ControlServer::Json;

// JSON-RPC 2.0's error codes.
constexpr int kParseError = -32700, kInvalidRequest = -32600, kMethodNotFound = -32601,
              kInvalidParams = -32602, kInternalError = -32603;
constexpr int kRefused = -32000, kNotAllowed = -32001;  // contourd's own

// Large enough for the largest batch. Parsing a message of only brackets takes 1 ms, a few on a Raspberry Pi.
constexpr std::size_t kLongestMessage = 8192;
constexpr std::size_t kMaxUnsent = 262144;       // beyond it, lossy notifications are left out
constexpr std::size_t kMaxUnsentEver = 4194304;  // beyond it, the client is closed: it is not reading
constexpr std::size_t kMaxClients = 64;
// Pause after accept() has failed.
constexpr Duration kRest = std::chrono::milliseconds(200);
// A user gets one turn per kTurnInterval on average, and kTurnsAtOnce without a wait after a quiet time.
constexpr Duration kTurnInterval = std::chrono::milliseconds(2);
constexpr int kTurnsAtOnce = 200;
constexpr std::size_t kLargestBatch = 64;
constexpr uid_t kRoot = 0;

Json error_answer(const Json& id, int code, const std::string& message) {
  return {{"jsonrpc", "2.0"}, {"error", {{"code", code}, {"message", message}}}, {"id", id}};
}

std::string text_of(const Json& message) {
  // ASCII only, so that control characters in file names do nothing to a terminal.
  return message.dump(-1, ' ', true, Json::error_handler_t::replace);
}

sockaddr_un address_of(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string text = path.string();
  if (text.size() >= sizeof address.sun_path) {
    throw std::runtime_error(
        fmt::format("the control socket's path is too long: {} has {} bytes, the limit is {}", text,
                    text.size(), sizeof address.sun_path - 1));
  }
  std::memcpy(address.sun_path, text.c_str(), text.size() + 1);
  return address;
}

FileDescriptor new_socket() {
  FileDescriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket.valid()) throw std::system_error(errno, std::generic_category(), "socket");
  return socket;
}

// Returns the peer's primary and supplementary groups at the time it connected (unix(7), SO_PEERGROUPS).
std::vector<gid_t> groups_of(int socket, gid_t own) {
  constexpr std::size_t kMaxGroups = 65536;  // NGROUPS_MAX
  std::vector<gid_t> groups(64);
  auto size = static_cast<socklen_t>(groups.size() * sizeof(gid_t));
  int failed = ::getsockopt(socket, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size);
  if (failed != 0 && errno == ERANGE && size <= kMaxGroups * sizeof(gid_t)) {
    groups.resize(size / sizeof(gid_t));
    failed = ::getsockopt(socket, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size);
  }
  groups.resize(failed == 0 ? size / sizeof(gid_t) : 0);
  groups.push_back(own);
  return groups;
}

std::optional<ControlServer::Peer> peer_of(int socket) {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return std::nullopt;
  return ControlServer::Peer{credentials.uid, credentials.pid, groups_of(socket, credentials.gid)};
}

}  // namespace

// One connection. Answers at most one request per turn of the event loop, and only as many as its user has
// turns, so that no client can delay a light or occupy the computer.
class ControlServer::Client {
 public:
  Client(ControlServer& server, FileDescriptor socket, Peer other_end, std::uint64_t connection)
      : peer(std::move(other_end)), number(connection), server_(server), socket_(std::move(socket)) {
    source_ = server_.loop_.on_ready(socket_.get(), EPOLLIN, kName,
                                     [this](std::uint32_t events) { ready(events); });
  }

  void send(const Json& message) { send_line(text_of(message) + "\n"); }
  void send_line(const std::string& line) {
    unsent_ += line;
    flush();
  }

  [[nodiscard]] bool closed() const { return source_ == nullptr; }
  [[nodiscard]] bool reads_slowly() const { return unsent_.size() > kMaxUnsent; }
  // Handles no further message until answer_later() has answered the current one.
  void wait_for_answer() { waiting_ = true; }
  // Sends the deferred answer, unless it is discarded, and continues with the next message.
  void answer_later(const Json& answer) {
    waiting_ = false;
    if (batch_) {
      add_to_batch(answer);
    } else if (!answer.is_discarded()) {
      send(answer);
    }
    if (!closed()) end_turn();
  }
  // Stops reading and sending; the server removes the client later, since this may be called from inside it.
  void close() {
    source_.reset();
    next_turn_.reset();
    server_.drop_closed_clients();
  }

  // Calls the server's callback the first time. Never called from inside a method.
  void report_disconnected() {
    if (!std::exchange(disconnect_reported_, true) && server_.disconnected_) server_.disconnected_(number);
  }

  const Peer peer;
  const std::uint64_t number;  // identifies the connection
  bool watching = false;
  std::chrono::steady_clock::time_point last_heard = std::chrono::steady_clock::now();

 private:
  static constexpr std::string_view kName = "a client of the control socket";

  // A batch that is being answered.
  struct Batch {
    Json messages;
    std::size_t next = 0;
    std::string answers;  // joined by commas
  };

  void ready(std::uint32_t events) {
    // Reported even if answers are still pending.
    if ((events & (EPOLLHUP | EPOLLERR)) != 0) {
      hung_up_ = true;
      report_disconnected();
    }
    if ((events & EPOLLOUT) != 0) flush();
    if (closed()) return;
    if (waiting_) {
      watch_socket();
    } else if ((events & EPOLLIN) != 0) {
      receive();
    } else if ((events & (EPOLLHUP | EPOLLERR)) != 0 && !busy_) {
      close();
    }
  }

  // Reads more input. All input so far has been answered.
  void receive() {
    std::array<char, 4096> buffer;
    const ssize_t bytes = ::read(socket_.get(), buffer.data(), buffer.size());
    if (bytes < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (bytes < 0) return close();
    if (bytes == 0) return end_input();
    received_.append(buffer.data(), static_cast<std::size_t>(bytes));
    last_heard = std::chrono::steady_clock::now();
    take_turn();
  }

  // Handles one line, or one message of a batch; end_turn() schedules the next.
  void take_turn() {
    if (batch_) {
      answer_next_of_batch();
    } else if (const std::size_t end = received_.find('\n'); end != std::string::npos) {
      const std::string line = received_.substr(0, end);
      received_.erase(0, end + 1);
      if (!std::exchange(skipping_, false)) handle(line);
    }
    if (closed()) return;
    if (!waiting_) return end_turn();
    busy_ = true;
    watch_socket();
  }

  void end_turn() {
    const bool more = batch_ || received_.find('\n') != std::string::npos;
    if (!more && received_.size() > kLongestMessage) skip_line();
    if (closed()) return;
    const TimePoint now = std::chrono::steady_clock::now();
    const TimePoint next = server_.take_turn_of(peer.user, now);
    busy_ = more || next > now;
    if (busy_) next_turn_ = server_.loop_.at(next, kName, [this] { go_on(); });
    watch_socket();
  }

  void go_on() {
    busy_ = false;
    if (batch_ || received_.find('\n') != std::string::npos) return take_turn();
    watch_socket();
  }

  void skip_line() {
    received_.clear();
    if (std::exchange(skipping_, true)) return;
    send(error_answer(nullptr, kInvalidRequest,
                      fmt::format("a message has at most {} bytes", kLongestMessage)));
  }

  // Handles the end of the client's input: the client still gets all answers.
  void end_input() {
    watching = false;
    input_ended_ = true;
    flush();
  }

  void handle(const std::string& line) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) return;
    Json message = Json::parse(line, nullptr, false);
    if (message.is_discarded()) {
      return send(error_answer(nullptr, kParseError, "not a JSON message; one message per line is expected"));
    }
    if (!message.is_array()) {
      const Json answer = server_.answer(message, *this);
      if (!answer.is_discarded() && !closed()) send(answer);
      return;
    }
    if (message.empty() || message.size() > kLargestBatch) {
      return send(
          error_answer(nullptr, kInvalidRequest, fmt::format("a batch has 1 to {} messages", kLargestBatch)));
    }
    batch_ = Batch{.messages = std::move(message), .answers = {}};
  }

  void answer_next_of_batch() {
    const Json answer = server_.answer(batch_->messages[batch_->next++], *this);
    if (!waiting_) add_to_batch(answer);
  }

  void add_to_batch(const Json& answer) {
    if (!answer.is_discarded()) batch_->answers += (batch_->answers.empty() ? "" : ",") + text_of(answer);
    if (batch_->next < batch_->messages.size()) return;
    const std::string answers = std::move(batch_->answers);
    batch_.reset();
    if (!answers.empty()) send_line("[" + answers + "]\n");
  }

  // Sends as much as the kernel takes without blocking.
  void flush() {
    if (!unsent_.empty()) {
      const ssize_t bytes = ::send(socket_.get(), unsent_.data(), unsent_.size(), MSG_NOSIGNAL);
      if (bytes < 0 && errno != EAGAIN && errno != EINTR) return close();
      if (bytes > 0) unsent_.erase(0, static_cast<std::size_t>(bytes));
    }
    if (unsent_.size() > kMaxUnsentEver || (unsent_.empty() && input_ended_)) return close();
    watch_socket();
  }

  // Selects the events to wait for. Further requests stay in the kernel's buffer until the pending ones are
  // answered.
  void watch_socket() {
    if (closed()) return;
    std::uint32_t events = (input_ended_ || busy_ ? 0U : EPOLLIN) | (unsent_.empty() ? 0U : EPOLLOUT);
    // A deferred answer may take long, but a hang-up must be noticed at once. epoll reports a hang-up along
    // with any event; EPOLLPRI is one that never occurs here.
    if (waiting_) events = hung_up_ ? 0U : events | EPOLLPRI;
    if (events != std::exchange(events_, events)) source_->set_events(events);
  }

  ControlServer& server_;
  FileDescriptor socket_;
  std::unique_ptr<EventLoop::IoSource> source_;  // null after close()
  EventLoop::SourcePtr next_turn_;
  std::uint32_t events_ = EPOLLIN;
  std::string received_, unsent_;
  std::optional<Batch> batch_;
  bool skipping_ = false;
  bool busy_ = false;     // next_turn_ is pending
  bool waiting_ = false;  // for a deferred answer
  bool hung_up_ = false;
  bool input_ended_ = false;
  bool disconnect_reported_ = false;
};

ControlServer::ControlServer(EventLoop& loop, std::filesystem::path socket, ControlMethods methods)
    : loop_(loop), path_(std::move(socket)), methods_(std::move(methods)) {
  methods_["watch"].description = "Subscribes this connection to notifications.";
  methods_["methods"] = {.description = "Reports the methods, and the valid values of their parameters.",
                         .call = [this](const Json&, const ControlCaller&) { return describe(methods_); }};
  listen();
  listener_source_ = loop_.on_ready(listener_.get(), EPOLLIN, "the control socket",
                                    [this](std::uint32_t) { accept_client(); });
}

ControlServer::~ControlServer() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void ControlServer::listen() {
  const sockaddr_un address = address_of(path_);
  const auto* generic = reinterpret_cast<const sockaddr*>(&address);
  const std::filesystem::file_status status = std::filesystem::symlink_status(path_);
  if (std::filesystem::exists(status)) {
    if (!std::filesystem::is_socket(status)) {
      throw std::runtime_error(fmt::format(
          "the control socket's path {} is in use by a file that is not a socket", path_.string()));
    }
    if (::connect(new_socket().get(), generic, sizeof address) == 0) {
      throw std::runtime_error(fmt::format("another contourd answers on {}", path_.string()));
    }
    std::filesystem::remove(path_);
  }
  listener_ = new_socket();
  if (::bind(listener_.get(), generic, sizeof address) != 0 || ::chmod(address.sun_path, 0660) != 0 ||
      ::listen(listener_.get(), SOMAXCONN) != 0) {
    throw std::runtime_error(fmt::format("cannot listen on {}: {}", path_.string(), std::strerror(errno)));
  }
}

void ControlServer::accept_client() {
  FileDescriptor socket(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!socket.valid()) {
    if (errno != EAGAIN && errno != ECONNABORTED && errno != EINTR) rest();
    return;
  }
  const std::optional<Peer> peer = peer_of(socket.get());
  if (!peer || !make_room(*peer)) return;
  const int key = socket.get();
  clients_[key] = std::make_unique<Client>(*this, std::move(socket), *peer, ++connections_);
}

// Stops accepting clients for kRest, because descriptors or memory are exhausted: epoll would report the
// waiting client in every turn.
void ControlServer::rest() {
  listener_source_->set_events(0);
  rest_timer_ = loop_.at(std::chrono::steady_clock::now() + kRest, "the control socket",
                         [this] { listener_source_->set_events(EPOLLIN); });
}

bool ControlServer::make_room(const Peer& newcomer) {
  std::map<uid_t, std::vector<Client*>> by_user;
  std::size_t open = 0;
  for (const auto& [key, client] : clients_) {
    if (client->closed()) continue;
    ++open;
    if (client->peer.user != kRoot || newcomer.user == kRoot)
      by_user[client->peer.user].push_back(client.get());
  }
  if (open < kMaxClients) return true;
  if (by_user.empty()) return false;
  const auto fewer = [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); };
  const std::vector<Client*>& most = std::ranges::max_element(by_user, fewer)->second;
  // A watching client waits for notifications and is not idle.
  const auto idler = [](const Client* a, const Client* b) {
    return std::pair(a->watching, a->last_heard) < std::pair(b->watching, b->last_heard);
  };
  (*std::ranges::min_element(most, idler))->close();
  return true;
}

Json ControlServer::answer(const Json& message, Client& client) {
  const Json no_answer(Json::value_t::discarded);
  const bool is_object = message.is_object();
  const bool has_id = is_object && message.contains("id");
  const auto is_id = [](const Json& id) { return id.is_string() || id.is_number() || id.is_null(); };
  if (!is_object || !message.contains("jsonrpc") || message["jsonrpc"] != "2.0" ||
      !message.contains("method") || !message["method"].is_string() || (has_id && !is_id(message["id"]))) {
    return error_answer(is_object && has_id && is_id(message["id"]) ? message["id"] : Json(), kInvalidRequest,
                        R"(not a JSON-RPC 2.0 request; expected {"jsonrpc":"2.0","method":...,"id":...})");
  }
  const Json result = call(message, client);
  if (!has_id || result.is_discarded()) return no_answer;
  if (result.contains("error")) {
    return {{"jsonrpc", "2.0"}, {"error", result["error"]}, {"id", message["id"]}};
  }
  return {{"jsonrpc", "2.0"}, {"result", result["result"]}, {"id", message["id"]}};
}

Json ControlServer::call(const Json& message, Client& client) {
  const auto failure = [](int code, const std::string& why) {
    return Json{{"error", {{"code", code}, {"message", why}}}};
  };
  const std::string name = message["method"].get<std::string>();
  const auto method = methods_.find(name);
  if (method == methods_.end()) {
    std::vector<std::string> names;
    for (const auto& [known, described] : methods_)
      names.push_back(known);
    return failure(kMethodNotFound, fmt::format("no method \"{}\"; there are {}{}", name,
                                                fmt::join(names, ", "), suggestion(name, names)));
  }
  try {
    const Json parameters =
        method->second.check(name, message.contains("params") ? message["params"] : Json());
    if (name == "watch") {
      client.watching = true;
      return Json{{"result", true}};
    }
    if (method->second.needs_service_rights && !has_service_rights(client.peer)) {
      return failure(kNotAllowed,
                     fmt::format("{} is for root and the group contourd-service: sudo adduser NAME "
                                 "contourd-service, then log in again",
                                 name));
    }
    const bool changes = method->second.changes_with(parameters);
    if (called_ && changes) called_(name, client.peer);
    if (method->second.call_later) return call_later(method->second, parameters, message, client);
    Json result{{"result", method->second.call(parameters, {client.number, client.peer.user})}};
    if (changed_ && changes) changed_();
    return result;
  } catch (const InvalidParameters& invalid) {
    return failure(kInvalidParams, invalid.what());
  } catch (const ControlRefusal& refusal) {
    return failure(kRefused, refusal.what());
  } catch (const std::exception& error) {
    return failure(kInternalError, error.what());
  }
}

// Returns the result, or a discarded value if the answer comes later.
Json ControlServer::call_later(const ControlMethod& method, const Json& parameters, const Json& message,
                               Client& client) {
  using Result = std::variant<Json, ControlRefusal>;
  struct Call {
    bool returned = false;
    std::optional<Result> result;  // set before the method has returned
  };
  const auto call = std::make_shared<Call>();
  const Json id = message.contains("id") ? message["id"] : Json(Json::value_t::discarded);
  const auto later = [this, alive = std::weak_ptr(alive_), changes = method.changes_with(parameters),
                      number = client.number, id, call](Result result) {
    if (!alive.expired() && changes && changed_ && std::holds_alternative<Json>(result)) changed_();
    if (!call->returned) {
      call->result = std::move(result);
      return;
    }
    if (alive.expired()) return;
    const auto is_asker = [number](const auto& entry) {
      return entry.second->number == number && !entry.second->closed();
    };
    const auto asker = std::ranges::find_if(clients_, is_asker);
    if (asker == clients_.end()) return;
    if (id.is_discarded()) return asker->second->answer_later(id);
    if (const auto* const refusal = std::get_if<ControlRefusal>(&result))
      return asker->second->answer_later(error_answer(id, kRefused, refusal->what()));
    asker->second->answer_later(
        {{"jsonrpc", "2.0"}, {"result", std::move(std::get<Json>(result))}, {"id", id}});
  };
  method.call_later(parameters, {client.number, client.peer.user}, later);
  call->returned = true;
  if (call->result) {
    if (const auto* const refusal = std::get_if<ControlRefusal>(&*call->result)) throw *refusal;
    return Json{{"result", std::move(std::get<Json>(*call->result))}};
  }
  client.wait_for_answer();
  return Json(Json::value_t::discarded);
}

bool ControlServer::has_service_rights(const Peer& peer) const {
  const bool member = service_group_ && std::ranges::find(peer.groups, *service_group_) != peer.groups.end();
  return peer.user == kRoot || peer.user == ::geteuid() || member;
}

bool ControlServer::is_watched() const {
  return std::ranges::any_of(
      clients_, [](const auto& entry) { return entry.second->watching && !entry.second->closed(); });
}

void ControlServer::notify(const std::string& method, const Json& params, Delivery delivery) {
  const std::string line = text_of({{"jsonrpc", "2.0"}, {"method", method}, {"params", params}}) + "\n";
  for (const auto& [key, client] : clients_) {
    if (!client->watching || client->closed()) continue;
    if (delivery == Delivery::Lossy && client->reads_slowly()) continue;
    client->send_line(line);
  }
}

ControlServer::TimePoint ControlServer::take_turn_of(uid_t user, TimePoint now) {
  // A user whose turns are all paid for is treated like a new user.
  std::erase_if(paid_until_, [now](const auto& entry) { return entry.second <= now; });
  TimePoint& paid = paid_until_.try_emplace(user, now).first->second;
  paid += kTurnInterval;
  return std::max(now, paid - kTurnsAtOnce * kTurnInterval);
}

void ControlServer::drop_closed_clients() {
  if (drop_timer_) return;
  // Deferred, because the call comes from inside a client.
  drop_timer_ = loop_.at(std::chrono::steady_clock::now(), "the control socket", [this] {
    drop_timer_.reset();
    for (const auto& [key, client] : clients_) {
      if (client->closed()) client->report_disconnected();
    }
    std::erase_if(clients_, [](const auto& entry) { return entry.second->closed(); });
  });
}

}  // namespace contourd
