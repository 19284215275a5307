// A client's connection to contourd: one JSON message per line (docs/control-api.md). Not thread-safe.
#pragma once

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "daemon/client/daemon_error.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

// A call of one of contourd's methods, with parameters by name.
struct Request {
  std::string method;
  nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
};

class DaemonConnection {
 public:
  using Json = nlohmann::ordered_json;
  using Time = std::chrono::steady_clock::time_point;

  // Connects to the daemon's socket. Throws DaemonError if that fails; the calls below throw it if the
  // connection breaks. `patience` is the timeout for connecting, and for each send, while the daemon is too
  // busy to accept; without it both block.
  explicit DaemonConnection(const std::filesystem::path& path,
                            std::optional<std::chrono::seconds> patience = std::nullopt);

  // Sends a request with parameters by name.
  void send(const std::string& method, int id, const Json& parameters = Json::object());
  // Returns the next message. Blocks until it is there.
  Json receive() { return *receive_until(Time::max()); }
  // Sends the request and returns the response, which has a "result" or an "error". Blocks.
  Json ask(const Request& request);
  // Returns the socket, for poll(): readable if a message may have arrived.
  [[nodiscard]] int descriptor() const { return socket_.get(); }
  // Returns the next message, or nullopt if none is complete by `time`. Blocks until then.
  std::optional<Json> receive_until(Time time);

 private:
  // Returns true once the socket is readable, false if `time` comes first.
  bool wait_until(Time time);

  std::string path_;
  FileDescriptor socket_;
  std::string received_;
};

}  // namespace contourd
