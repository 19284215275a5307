// A contourd for fuzz targets of contourd-web: a control socket that answers every call alike. Event loop's
// thread only.
#pragma once

#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <list>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "daemon/system/event_loop.hpp"
#include "hw/file_descriptor.hpp"
#include "tests/fuzz/demand.hpp"

namespace contourd::fuzz {

inline sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  return address;
}

inline FileDescriptor listen_at(const std::string& path) {
  FileDescriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const sockaddr_un address = address_of(path);
  ::unlink(path.c_str());
  demand(::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
             ::listen(socket.get(), 16) == 0,
         "a socket cannot be made");
  return socket;
}

class FakePrinter {
 public:
  using Json = nlohmann::ordered_json;

  // Answers each call with a status in which every file has three bytes, with a waiting job a.stl and a
  // resin; or refuses it.
  FakePrinter(EventLoop& loop, const std::string& socket, const std::string& spool, bool refuses)
      : loop_(loop), listener_(listen_at(socket)), refuses_(refuses) {
    status_ = {
        {"printer", "p"},
        {"spool", spool},
        {"state", "idle"},
        {"job", nullptr},
        {"queued", 0},
        {"plate", "clear"},
        {"plate_job", nullptr},
        {"not_ready_reason", nullptr},
        {"held", nullptr},
        {"interrupted", nullptr},
        {"waiting_for", nullptr},
        {"reminders", Json::array()},
        {"last", nullptr},
        {"dark", true},
        {"jobs", {{{"job", "a"}, {"file", "a.stl"}, {"state", "unaccepted"}, {"asks", {"to_be_confirmed"}}}}},
        {"resins", {{{"resin", "a"}, {"is_default", true}, {"trouble", nullptr}}}},
        {"picture", 1},
        {"version", 1},
        {"bytes", 3},
        {"from", 0},
        {"data", "YWJj"}};
    source_ =
        loop.on_ready(listener_.get(), EPOLLIN, "the fake printer", [this](std::uint32_t) { accept(); });
  }

  // Returns the methods that were called, in order.
  [[nodiscard]] const std::vector<std::string>& called() const { return called_; }

 private:
  struct Client {
    FileDescriptor socket;
    std::string heard;
    std::unique_ptr<EventLoop::IoSource> source;
  };

  void accept() {
    FileDescriptor socket(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!socket.valid()) return;
    Client& client = clients_.emplace_back();
    client.socket = std::move(socket);
    client.source = loop_.on_ready(client.socket.get(), EPOLLIN, "a call",
                                   [this, &client](std::uint32_t) { hear(client); });
  }
  void hear(Client& client) {
    std::array<char, 16'384> buffer;
    const ssize_t bytes = ::read(client.socket.get(), buffer.data(), buffer.size());
    if (bytes <= 0) return client.source->set_events(0);
    client.heard.append(buffer.data(), static_cast<std::size_t>(bytes));
    for (std::size_t end = 0; (end = client.heard.find('\n')) != std::string::npos;) {
      answer(client, Json::parse(client.heard.substr(0, end), nullptr, false));
      client.heard.erase(0, end + 1);
    }
  }
  void answer(const Client& client, const Json& call) {
    demand(call.is_object() && call.contains("method") && call["method"].is_string() && call.contains("id"),
           "contourd gets something that is no call");
    demand(!call.contains("params") || call["params"].is_object(), "a call has no parameters by name");
    called_.push_back(call["method"].get<std::string>());
    Json reply{{"jsonrpc", "2.0"}, {"id", call["id"]}};
    if (refuses_)
      reply["error"] = {{"code", -32000}, {"message", "it is not the time"}};
    else
      reply["result"] = status_;
    const std::string text = reply.dump() + "\n";
    (void)::send(client.socket.get(), text.data(), text.size(), MSG_NOSIGNAL);
  }

  EventLoop& loop_;
  FileDescriptor listener_;
  bool refuses_;
  Json status_;
  std::vector<std::string> called_;
  std::unique_ptr<EventLoop::IoSource> source_;
  std::list<Client> clients_;
};

}  // namespace contourd::fuzz
