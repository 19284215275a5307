// The control socket: JSON-RPC 2.0 over a Unix stream socket, one message per line. Whatever a client sends,
// it gets an answer and stays connected, unless it is idle and its connection is needed for another client.
// The clients of one user together get at most some hundred answers per second; further requests wait. Event
// loop's thread only.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/control/control_method.hpp"
#include "daemon/system/event_loop.hpp"

namespace contourd {

class ControlServer {
 public:
  using Json = ControlMethod::Json;
  // The process at the other end of a connection, as reported by the kernel.
  struct Peer {
    uid_t user = 0;
    pid_t process = 0;
    std::vector<gid_t> groups{};  // primary and supplementary
  };

  // Listens at once; the socket is readable and writable for owner and group. Replaces the socket of a
  // contourd that no longer runs. Throws std::runtime_error if the path is too long, or is in use by a
  // running contourd or by a file that is not a socket.
  ControlServer(EventLoop& loop, std::filesystem::path socket, ControlMethods methods);
  ~ControlServer();
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;

  // Calls `call` before each method that changes something.
  void on_call(std::function<void(const std::string& method, const Peer& peer)> call) {
    called_ = std::move(call);
  }
  // Calls `call` after each method that has changed something, before its answer is sent.
  void on_changed(std::function<void()> call) { changed_ = std::move(call); }

  // Calls `call` once for each closed connection, as soon as the close is noticed. Never from inside a
  // method.
  void on_disconnected(std::function<void(std::uint64_t connection)> call) {
    disconnected_ = std::move(call);
  }
  // Sets the group whose members, besides root and this process' own user, may call methods that need service
  // rights.
  void set_service_group(std::optional<gid_t> group) { service_group_ = group; }

  // Sends a notification to every client that called "watch". A client that reads too slowly misses Lossy
  // notifications.
  enum class Delivery { Lossy, Certain };
  void notify(const std::string& method, const Json& params, Delivery delivery);
  // True if at least one client is watching.
  [[nodiscard]] bool is_watched() const;

 private:
  class Client;
  using TimePoint = std::chrono::steady_clock::time_point;

  void listen();
  void accept_client();
  void rest();
  // If the number of clients is at its limit, closes the longest idle client of the user with the most
  // clients. A client of root is never closed for another user's. Returns false if no client can be closed.
  [[nodiscard]] bool make_room(const Peer& newcomer);
  // Returns the answer to one message; discarded for a notification.
  Json answer(const Json& message, Client& client);
  Json call(const Json& message, Client& client);
  Json call_later(const ControlMethod& method, const Json& parameters, const Json& message, Client& client);
  [[nodiscard]] bool has_service_rights(const Peer& peer) const;
  // Counts one turn of the user and returns the time of the next one.
  [[nodiscard]] TimePoint take_turn_of(uid_t user, TimePoint now);
  void drop_closed_clients();

  EventLoop& loop_;
  std::filesystem::path path_;
  ControlMethods methods_;
  FileDescriptor listener_;
  std::unique_ptr<EventLoop::IoSource> listener_source_;
  std::map<int, std::unique_ptr<Client>> clients_;
  std::map<uid_t, TimePoint> paid_until_;  // for users who had turns recently
  std::function<void(const std::string&, const Peer&)> called_;
  std::function<void()> changed_;
  std::function<void(std::uint64_t)> disconnected_;
  std::optional<gid_t> service_group_;
  std::uint64_t connections_ = 0;  // accepted so far
  EventLoop::SourcePtr drop_timer_, rest_timer_;
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);  // for deferred answers
};

}  // namespace contourd
