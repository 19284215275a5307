// The control socket: JSON-RPC 2.0 over a Unix stream socket, one message a line. Whatever a client sends, it
// gets an answer and stays connected, unless it is idle and others want to come in. One user's clients
// together get some hundred answers a second; what they ask beyond that waits. Event loop's thread only.
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
  // Who is at the other end of a connection, as the kernel says.
  struct Peer {
    uid_t user = 0;
    pid_t process = 0;
    std::vector<gid_t> groups{};  // its own and all others
  };

  // Listens at once; the socket is readable and writable for owner and group. The socket of a contourd that
  // is no more is replaced. Throws std::runtime_error: the path is too long, taken by something else, or by a
  // running contourd.
  ControlServer(EventLoop& loop, std::filesystem::path socket, ControlMethods methods);
  ~ControlServer();
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;

  // Calls `call` before each method that changes something.
  void on_call(std::function<void(const std::string& method, const Peer& peer)> call) {
    called_ = std::move(call);
  }

  // Calls `call` once for each connection that is no more, when that is known. Never from inside a method.
  void on_disconnected(std::function<void(std::uint64_t connection)> call) {
    disconnected_ = std::move(call);
  }
  // Methods that need service rights are for root, this process' own user and members of this group.
  void set_service_group(std::optional<gid_t> group) { service_group_ = group; }

  // Sends a notification to every client that called "watch". A client that reads too slowly misses those
  // that need not arrive.
  enum class Delivery { Lossy, Certain };
  void notify(const std::string& method, const Json& params, Delivery delivery);
  // Whether there is a client to notify.
  [[nodiscard]] bool is_watched() const;

 private:
  class Client;
  using TimePoint = std::chrono::steady_clock::time_point;

  void listen();
  void accept_client();
  void rest();
  // When there are as many clients as there may be: closes the one that has been idle for longest, of the
  // user who has most, for `newcomer`. None of root's gives way to another user's. False when none can.
  [[nodiscard]] bool make_room(const Peer& newcomer);
  // One message's answer; discarded for a notification.
  Json answer(const Json& message, Client& client);
  Json call(const Json& message, Client& client);
  Json call_later(const ControlMethod& method, const Json& parameters, const Json& message, Client& client);
  [[nodiscard]] bool has_service_rights(const Peer& peer) const;
  // Counts a turn of the user's and tells when the next one is.
  [[nodiscard]] TimePoint take_turn_of(uid_t user, TimePoint now);
  void drop_closed_clients();

  EventLoop& loop_;
  std::filesystem::path path_;
  ControlMethods methods_;
  FileDescriptor listener_;
  std::unique_ptr<EventLoop::IoSource> listener_source_;
  std::map<int, std::unique_ptr<Client>> clients_;
  std::map<uid_t, TimePoint> paid_until_;  // of users who had turns lately
  std::function<void(const std::string&, const Peer&)> called_;
  std::function<void(std::uint64_t)> disconnected_;
  std::optional<gid_t> service_group_;
  std::uint64_t connections_ = 0;  // so many were made
  EventLoop::SourcePtr drop_timer_, rest_timer_;
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);  // for answers that come later
};

}  // namespace contourd
