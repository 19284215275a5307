// Fuzz target: any bytes to an HTTP server of contourd-web, in two portions (the first byte chooses where
// they are split, its lowest bit whether contourd refuses every call, and the next two bits the server: the
// page, NanoDLP's or Odyssey's interface). The key for slicers is kKey, and each file of contourd has three
// bytes. Every reply of contourd-web has a known status, and every refusal is one sentence; what
// libmicrohttpd answers by itself is not looked at. A valid request afterwards, by another client, is
// answered.
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/web/hosts/nanodlp_host.hpp"
#include "daemon/web/hosts/odyssey_host.hpp"
#include "daemon/web/web_service.hpp"
#include "tests/fuzz/demand.hpp"
#include "tests/fuzz/fake_printer.hpp"
#include "tests/fuzz/quiet_log.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::fuzz {
namespace {

constexpr const char* kKey = "00112233445566778899aabbccddeeff";
enum class Server { Page = 0, Nanodlp = 1, Odyssey = 2 };

// The last request to a server, and the body of its reply.
struct LastTalk {
  std::string_view request, reply;
};
LastTalk last_talk(Server server) {
  switch (server) {
    case Server::Nanodlp:
      return {"GET /notification HTTP/1.1\r\nHost: printer\r\nConnection: close\r\n\r\n", "[]"};
    case Server::Odyssey:
      return {"GET /version HTTP/1.1\r\nHost: printer\r\nConnection: close\r\n\r\n", "contourd 1"};
    case Server::Page:
      break;
  }
  return {
      "GET /api/session HTTP/1.1\r\nHost: printer\r\nX-Api-Key: 00112233445566778899aabbccddeeff\r\n"
      "Connection: close\r\n\r\n",
      R"({"role":"print"})"};
}
// Real time for the first client, whose reply may have no end.
constexpr std::chrono::milliseconds kPatience{200};

// A client in the server's own loop: sends everything, and reads until the server closes, or for a while.
class WebTalk {
 public:
  // Calls `over` once, from the loop, when it is over.
  WebTalk(EventLoop& loop, const std::string& socket, std::string_view first, std::string second,
          std::function<void()> over)
      : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)),
        second_(std::move(second)),
        over_(std::move(over)) {
    const sockaddr_un address = address_of(socket);
    demand(::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0,
           "the connection failed");
    say(first);
    source_ = loop.on_ready(socket_.get(), EPOLLIN, "the client", [this](std::uint32_t) { hear(); });
    const auto now = std::chrono::steady_clock::now();
    rest_ = loop.at(now, "the client's rest", [this] {
      say(second_);
      ::shutdown(socket_.get(), SHUT_WR);
    });
    end_ = loop.at(now + kPatience, "the client's end", [this] { end(); });
  }

  [[nodiscard]] const std::string& heard() const { return heard_; }
  [[nodiscard]] bool is_whole() const { return whole_; }

 private:
  // The server may have closed the connection.
  void say(std::string_view bytes) { (void)::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  void hear() {
    std::array<char, 16'384> buffer;
    const ssize_t bytes = ::read(socket_.get(), buffer.data(), buffer.size());
    if (bytes > 0) {
      heard_.append(buffer.data(), static_cast<std::size_t>(bytes));
      return;
    }
    whole_ = true;
    end();
  }
  void end() {
    if (std::exchange(ended_, true)) return;
    source_->set_events(0);
    over_();
  }

  FileDescriptor socket_;
  std::string second_, heard_;
  std::function<void()> over_;
  bool whole_ = false, ended_ = false;
  std::unique_ptr<EventLoop::IoSource> source_;
  EventLoop::SourcePtr rest_, end_;
};

// A reply of the server: its status, its headers and what follows them.
struct WebReply {
  unsigned status = 0;
  std::string_view headers, rest;

  [[nodiscard]] std::string_view header(std::string_view name) const {
    const std::size_t at = headers.find(name);
    if (at == std::string_view::npos) return {};
    const std::string_view value = headers.substr(at + name.size());
    return value.substr(0, value.find('\r'));
  }
};

// Returns the first reply; nullopt if there is no whole one.
std::optional<WebReply> next_reply(std::string_view heard) {
  constexpr std::string_view kEnd = "\r\n\r\n";
  constexpr std::size_t kStatusAt = 9, kStatusEnd = 12;
  const std::size_t end = heard.find(kEnd);
  if (end == std::string_view::npos) return std::nullopt;
  demand(heard.starts_with("HTTP/1.") && end >= kStatusEnd, "a reply does not begin with a status");
  WebReply reply{.headers = heard.substr(0, end + 2), .rest = heard.substr(end + kEnd.size())};
  const auto read = std::from_chars(heard.data() + kStatusAt, heard.data() + kStatusEnd, reply.status);
  demand(read.ec == std::errc() && read.ptr == heard.data() + kStatusEnd, "a reply has no status");
  return reply;
}

void demand_refusal(std::string_view body) {
  demand(body.size() > 1 && body.size() <= 1024 && body.ends_with('\n'), "a refusal is no line");
  const std::string line(body.substr(0, body.size() - 1));
  demand(printable(line) == line, "a refusal is not one printable line");
}

// Checks the replies, up to one whose end cannot be known.
void demand_replies(std::string_view heard, bool is_whole) {
  constexpr std::array kStatuses{200U, 201U, 204U, 206U, 302U, 400U, 401U, 403U, 404U, 405U,
                                 409U, 411U, 413U, 415U, 416U, 422U, 429U, 501U, 503U, 507U};
  while (const std::optional<WebReply> reply = next_reply(heard)) {
    heard = reply->rest;
    if (reply->status == 100) continue;  // the body may follow
    const std::string_view length = reply->header("\r\nContent-Length: ");
    std::size_t bytes = 0;
    if (length.empty() && reply->status != 204) return;
    std::from_chars(length.data(), length.data() + length.size(), bytes);
    if (bytes > heard.size()) return demand(!is_whole || heard.empty(), "a reply has no end");
    const bool is_ours = !reply->header("\r\nX-Content-Type-Options: ").empty();
    if (!is_ours) return;
    demand(std::ranges::find(kStatuses, reply->status) != kStatuses.end(), "a reply has an unknown status");
    // The reply to HEAD has a length, but no body: the next reply follows at once, or nothing does.
    if (bytes > 0 && (heard.empty() || heard.starts_with("HTTP/1."))) continue;
    if (reply->status >= 400) demand_refusal(heard.substr(0, bytes));
    heard.remove_prefix(bytes);
  }
}

void check(std::uint8_t shape, const std::string& bytes) {
  static const testing::TemporaryFolder folder;
  static const std::string spool = (folder.path() / "spool").string();
  static const std::string incoming = spool + "/incoming";
  std::filesystem::create_directories(incoming);
  const std::string control = (folder.path() / "control.sock").string();
  const std::string web = (folder.path() / "web.sock").string();
  const std::size_t part = bytes.size() * shape / 256;
  EventLoop loop;
  const Log log(loop);
  const QuietLog quiet;
  const FakePrinter printer(loop, control, spool, (shape & 1U) != 0);
  std::vector<FileDescriptor> listeners;
  listeners.push_back(listen_at(web));
  const web::WebConfig config{.control_socket = control,
                              .names = {},
                              .session = std::chrono::hours(1),
                              .largest_upload_bytes = 1000,
                              .min_free_disk_bytes = 0};
  const auto server = static_cast<Server>(shape >> 1U & 3U);
  // A client of this socket has no address.
  const web::HostAccess access{.clients = {""}, .names = {"printer"}};
  std::optional<web::HostPrinter> hosts_printer;
  if (server == Server::Nanodlp || server == Server::Odyssey) hosts_printer.emplace(loop, log, config);
  std::optional<web::NanodlpHost> nanodlp;
  std::optional<web::OdysseyHost> odyssey;
  std::optional<web::WebService> service;
  if (server == Server::Nanodlp)
    nanodlp.emplace(loop, *hosts_printer, access, "1", std::move(listeners));
  else if (server == Server::Odyssey)
    odyssey.emplace(loop, *hosts_printer, access, "1", std::move(listeners));
  else  // no password has this hash, which costs no time
    service.emplace(loop, log, config, web::WebSecrets{.password_hash = "*", .key = kKey},
                    std::vector<std::string>{"printer"}, std::move(listeners));
  const LastTalk ending = last_talk(server);
  std::optional<WebTalk> last;
  const WebTalk talk(loop, web, std::string_view(bytes).substr(0, part), bytes.substr(part),
                     [&] { last.emplace(loop, web, ending.request, "", [&loop] { loop.stop(); }); });
  loop.run();
  demand_replies(talk.heard(), talk.is_whole());
  const std::optional<WebReply> reply = next_reply(last->heard());
  demand(reply && reply->status == 200 && reply->rest == ending.reply, "the last request is not answered");
  for (const auto& each : std::filesystem::directory_iterator(incoming))
    std::filesystem::remove_all(each.path());
}

}  // namespace
}  // namespace contourd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 0)
    contourd::fuzz::check(data[0], std::string(reinterpret_cast<const char*>(data) + 1, size - 1));
  return 0;
}
