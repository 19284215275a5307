#include "daemon/web/listen_sockets.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <sys/socket.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "daemon/system/readable.hpp"

namespace contourd::web {
namespace {

using AddressPtr = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

AddressPtr address_info(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (colon != std::string::npos && colon > 0) {
    std::string host = text.substr(0, colon);
    if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
    if (::getaddrinfo(host.c_str(), text.c_str() + colon + 1, &hints, &found) == 0)
      return {found, ::freeaddrinfo};
  }
  throw std::runtime_error(fmt::format(
      "{}: expected an address and a port, such as 127.0.0.1:8080 or [::1]:8080", printable(text)));
}

}  // namespace

std::vector<FileDescriptor> passed_sockets() {
  std::vector<FileDescriptor> sockets;
  const int count = ::sd_listen_fds(1);
  for (int i = 0; i < count; ++i)
    sockets.emplace_back(SD_LISTEN_FDS_START + i);
  return sockets;
}

FileDescriptor listen_on(const std::string& address) {
  const AddressPtr where = address_info(address);
  FileDescriptor socket(::socket(where->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int on = 1;
  (void)::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(socket.get(), where->ai_addr, where->ai_addrlen) != 0 || ::listen(socket.get(), SOMAXCONN) != 0)
    throw std::runtime_error(
        fmt::format("cannot listen on {}: {}", printable(address), std::strerror(errno)));
  return socket;
}

void check_address(const std::string& address) {
  (void)address_info(address);
}

std::vector<std::string> network_addresses() {
  std::vector<std::string> addresses;
  ifaddrs* first = nullptr;
  if (::getifaddrs(&first) != 0) return addresses;
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> owner(first, ::freeifaddrs);
  for (const ifaddrs* each = first; each != nullptr; each = each->ifa_next) {
    if (each->ifa_addr == nullptr || each->ifa_addr->sa_family != AF_INET ||
        (each->ifa_flags & IFF_LOOPBACK) != 0)
      continue;
    std::array<char, INET_ADDRSTRLEN> text{};
    ::inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(each->ifa_addr)->sin_addr, text.data(),
                text.size());
    addresses.emplace_back(text.data());
  }
  return addresses;
}

std::vector<std::string> addresses_of(const std::vector<FileDescriptor>& sockets) {
  std::vector<std::string> addresses;
  for (const FileDescriptor& socket : sockets) {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    std::array<char, INET6_ADDRSTRLEN> host{};
    std::array<char, 8> port{};
    auto* const name = reinterpret_cast<sockaddr*>(&address);
    if (::getsockname(socket.get(), name, &size) != 0 ||
        ::getnameinfo(name, size, host.data(), host.size(), port.data(), port.size(),
                      NI_NUMERICHOST | NI_NUMERICSERV) != 0)
      continue;
    const bool is_ipv6 = address.ss_family == AF_INET6;
    addresses.push_back(
        fmt::format("{}{}{}:{}", is_ipv6 ? "[" : "", host.data(), is_ipv6 ? "]" : "", port.data()));
  }
  return addresses;
}

int port_of(const FileDescriptor& socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  if (address.ss_family == AF_INET) return ntohs(reinterpret_cast<const sockaddr_in*>(&address)->sin_port);
  if (address.ss_family == AF_INET6) return ntohs(reinterpret_cast<const sockaddr_in6*>(&address)->sin6_port);
  return 0;
}

std::vector<std::string> own_names() {
  std::array<char, 256> text{};
  if (::gethostname(text.data(), text.size() - 1) != 0 || text.front() == '\0') return {};
  std::string name = text.data();
  for (char& letter : name)
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  const std::string first = name.substr(0, name.find('.'));
  return first == name ? std::vector{name} : std::vector{name, first};
}

}  // namespace contourd::web
