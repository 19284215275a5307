#include "daemon/web/http_server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <microhttpd.h>
#include <netdb.h>
#include <sys/epoll.h>
#include <sys/random.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <stdexcept>
#include <utility>

namespace contourd::web {
namespace {

using std::chrono::steady_clock;

constexpr std::string_view kClientsName = "the clients of the web page";
// Clients that are being cut off count for libmicrohttpd until it has closed them.
constexpr unsigned kMostConnections = 2 * HttpServer::kMostClients;
// Nonces of digest authentication at the same time; a client whose nonce had to go is asked again.
constexpr unsigned kNonces = 1024;
constexpr int kMostAcceptedAtOnce = 16;
constexpr Duration kRest = std::chrono::milliseconds(200), kLookAgain = std::chrono::seconds(1);

// Returns the address without a port or a scope; an IPv4 address in an IPv6 one is written as IPv4.
std::string text_of(const sockaddr_storage& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address.ss_family == AF_INET) {
    const auto* const four = reinterpret_cast<const sockaddr_in*>(&address);
    ::inet_ntop(AF_INET, &four->sin_addr, text.data(), text.size());
  } else if (address.ss_family == AF_INET6) {
    const auto* const six = reinterpret_cast<const sockaddr_in6*>(&address);
    if (IN6_IS_ADDR_V4MAPPED(&six->sin6_addr))
      ::inet_ntop(AF_INET, &six->sin6_addr.s6_addr[12], text.data(), text.size());
    else
      ::inet_ntop(AF_INET6, &six->sin6_addr, text.data(), text.size());
  }
  return text.data();
}

std::string address_of(int socket, int (*get)(int, sockaddr*, socklen_t*)) {
  sockaddr_storage address{};
  socklen_t bytes = sizeof address;
  if (get(socket, reinterpret_cast<sockaddr*>(&address), &bytes) != 0) return "";
  return text_of(address);
}

HttpClient& client_of(MHD_Connection* connection) {
  return *static_cast<HttpClient*>(
      MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT)->socket_context);
}

}  // namespace

// libmicrohttpd's calls, which must not throw.
struct HttpServer::Callbacks {
  using RequestPtr = std::shared_ptr<HttpRequest>;

  static void client_changed(void* self, MHD_Connection* connection, void** context,
                             MHD_ConnectionNotificationCode code) {
    HttpServer& server = *static_cast<HttpServer*>(self);
    if (code == MHD_CONNECTION_NOTIFY_CLOSED) {
      const std::unique_ptr<HttpClient> client(static_cast<HttpClient*>(*context));
      server.clients_.erase(client.get());
      return;
    }
    auto client = std::make_unique<HttpClient>();
    client->socket = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    client->ends.peer = address_of(client->socket, ::getpeername);
    client->ends.local = address_of(client->socket, ::getsockname);
    client->since = steady_clock::now();
    client->deadline = client->since + kHeaderTime;
    server.clients_.insert(client.get());
    *context = client.release();
  }

  static MHD_Result handle(void* self, MHD_Connection* connection, const char* url, const char* method,
                           const char* /*version*/, const char* piece, std::size_t* bytes, void** context) {
    HttpServer& server = *static_cast<HttpServer*>(self);
    const bool first = *context == nullptr;
    if (first) {
      HttpClient& client = client_of(connection);
      auto request = std::make_unique<RequestPtr>(
          std::make_shared<HttpRequest>(server, client, connection, method, url));
      server.unfinished_.insert(request->get());
      *context = request.release();
    }
    const RequestPtr request = *static_cast<RequestPtr*>(*context);
    bool good = true;
    if (first) {
      server.handler_(request);
      // libmicrohttpd closes the connection after a reply in this first call, which is right for a request
      // whose body is not read. Others are answered in the next call, so that the client can send the next
      // request.
      good = !request->has_reply() || !request->has_body() || request->send();
    } else if (*bytes > 0) {
      good = request->take({piece, *bytes});
      *bytes = 0;
    } else {
      good = request->end();
    }
    return good ? MHD_YES : MHD_NO;
  }

  static void completed(void* self, MHD_Connection* /*connection*/, void** context,
                        MHD_RequestTerminationCode /*why*/) {
    const std::unique_ptr<RequestPtr> request(static_cast<RequestPtr*>(std::exchange(*context, nullptr)));
    if (!request) return;
    HttpServer& server = *static_cast<HttpServer*>(self);
    server.unfinished_.erase(request->get());
    (*request)->client_->deadline = steady_clock::now() + kHeaderTime;
    (*request)->connection_ = nullptr;
    // The handler's parts may refer to the request.
    (*request)->body_.reset();
    (*request)->stream_.reset();
  }
};

HttpServer::HttpServer(EventLoop& loop, std::vector<FileDescriptor> listeners, Handler handler)
    : loop_(loop), handler_(std::move(handler)), listeners_(std::move(listeners)) {
  std::array<char, 32> random{};
  if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size()))
    throw std::runtime_error("the kernel has no random numbers");
  daemon_ = MHD_start_daemon(MHD_USE_EPOLL | MHD_USE_NO_LISTEN_SOCKET | MHD_ALLOW_SUSPEND_RESUME, 0, nullptr,
                             nullptr, &Callbacks::handle, this,                               //
                             MHD_OPTION_NOTIFY_CONNECTION, &Callbacks::client_changed, this,  //
                             MHD_OPTION_NOTIFY_COMPLETED, &Callbacks::completed, this,        //
                             MHD_OPTION_CONNECTION_LIMIT, kMostConnections,                   //
                             MHD_OPTION_CONNECTION_MEMORY_LIMIT, kMostHeaderBytes,            //
                             MHD_OPTION_STRICT_FOR_CLIENT, 1,                                 //
                             MHD_OPTION_DIGEST_AUTH_RANDOM, random.size(), random.data(),     //
                             MHD_OPTION_NONCE_NC_SIZE, kNonces, MHD_OPTION_END);
  const MHD_DaemonInfo* const info =
      daemon_ == nullptr ? nullptr : MHD_get_daemon_info(daemon_, MHD_DAEMON_INFO_EPOLL_FD);
  if (info == nullptr) throw std::runtime_error("the HTTP server cannot be started: libmicrohttpd refuses");
  epoll_source_ = loop_.on_ready(info->epoll_fd, EPOLLIN, kClientsName, [this](std::uint32_t) { run(); });
  for (const FileDescriptor& listener : listeners_) {
    const int socket = listener.get();
    ::fcntl(socket, F_SETFL, ::fcntl(socket, F_GETFL) | O_NONBLOCK);
    listener_sources_[socket] = loop_.on_ready(socket, EPOLLIN, kClientsName,
                                               [this, socket](std::uint32_t) { accept_clients(socket); });
  }
}

HttpServer::~HttpServer() {
  // A connection that waits must go on before the server stops.
  const std::set<HttpRequest*> unfinished = unfinished_;
  for (HttpRequest* request : unfinished)
    request->go_on();
  epoll_source_.reset();
  if (daemon_ != nullptr) MHD_stop_daemon(daemon_);
}

void HttpServer::accept_clients(int listener) {
  for (int i = 0; i < kMostAcceptedAtOnce; ++i) {
    sockaddr_storage address{};
    socklen_t bytes = sizeof address;
    FileDescriptor socket(
        ::accept4(listener, reinterpret_cast<sockaddr*>(&address), &bytes, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!socket.valid()) {
      if (errno != EAGAIN && errno != ECONNABORTED && errno != EINTR) rest(listener);
      break;
    }
    if (!make_room()) continue;
    // libmicrohttpd owns the descriptor, even if it refuses the client.
    const int given = ::fcntl(socket.get(), F_DUPFD_CLOEXEC, 0);
    if (given < 0) continue;
    MHD_add_connection(daemon_, given, reinterpret_cast<sockaddr*>(&address), bytes);
  }
  look_at_clients_later();
  run();
}

// Stops accepting clients for a while, because descriptors or memory are exhausted.
void HttpServer::rest(int listener) {
  listener_sources_[listener]->set_events(0);
  rest_timer_ = loop_.at(steady_clock::now() + kRest, kClientsName, [this] {
    for (const auto& [socket, source] : listener_sources_)
      source->set_events(EPOLLIN);
  });
}

// Makes room for one more client, if there are kMostClients: cuts off the oldest client that has not logged
// in, of the address with the most clients of that kind. Returns false if all have logged in.
bool HttpServer::make_room() {
  std::map<std::string, std::vector<HttpClient*>> strangers;
  std::size_t open = 0;
  for (HttpClient* client : clients_) {
    if (client->cut_off) continue;
    ++open;
    if (!client->has_logged_in) strangers[client->ends.peer].push_back(client);
  }
  if (open < kMostClients) return true;
  if (strangers.empty() || clients_.size() >= kMostConnections) return false;
  const auto fewer = [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); };
  const std::vector<HttpClient*>& most = std::ranges::max_element(strangers, fewer)->second;
  HttpClient* const oldest = *std::ranges::min_element(most, {}, &HttpClient::since);
  oldest->cut_off = true;
  ::shutdown(oldest->socket, SHUT_RDWR);
  return true;
}

void HttpServer::run() {
  MHD_run(daemon_);
  MHD_UNSIGNED_LONG_LONG milliseconds = 0;
  run_timer_.reset();
  if (MHD_get_timeout(daemon_, &milliseconds) == MHD_YES)
    run_at(steady_clock::now() + std::chrono::milliseconds(milliseconds));
}

void HttpServer::run_soon() {
  run_at(steady_clock::now());
}

void HttpServer::run_at(TimePoint when) {
  run_timer_ = loop_.at(when, kClientsName, [this] { run(); });
}

void HttpServer::look_at_clients_later() {
  if (slow_timer_ || clients_.empty()) return;
  slow_timer_ = loop_.at(steady_clock::now() + kLookAgain, kClientsName, [this] { cut_slow_clients(); });
}

void HttpServer::cut_slow_clients() {
  const auto now = steady_clock::now();
  for (HttpClient* client : clients_) {
    if (client->cut_off || now < client->deadline) continue;
    client->cut_off = true;
    ::shutdown(client->socket, SHUT_RDWR);
  }
  slow_timer_.reset();
  run();
  look_at_clients_later();
}

}  // namespace contourd::web
