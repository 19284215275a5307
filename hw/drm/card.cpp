#include "hw/drm/card.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>
#include <sstream>
#include <utility>

#include "hw/hardware_error.hpp"
#include "hw/owned.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

using Resources = Owned<drmModeRes, drmModeFreeResources>;
using KernelConnector = Owned<drmModeConnector, drmModeFreeConnector>;
using KernelEncoder = Owned<drmModeEncoder, drmModeFreeEncoder>;
using Version = Owned<drmVersion, drmFreeVersion>;

// "; members of the group video may open it"
std::string who_may_open(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return "";
  const group* owner = ::getgrgid(status.st_gid);
  return "; members of the group " +
         (owner != nullptr ? std::string(owner->gr_name) : std::to_string(status.st_gid)) + " may open it";
}

FileDescriptor opened(const fs::path& path) {
  // Non-blocking: events are read when they are there, never waited for.
  const int fd = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
  if (fd >= 0) return FileDescriptor(fd);
  const int error = errno;
  throw HardwareError(path.string() + " cannot be opened: " + std::strerror(error) +
                      (error == EACCES ? who_may_open(path) : ""));
}

Connector::Status status_of(drmModeConnection connection) {
  if (connection == DRM_MODE_CONNECTED) return Connector::Status::Connected;
  return connection == DRM_MODE_DISCONNECTED ? Connector::Status::Disconnected : Connector::Status::Unknown;
}

std::string name_of(const drmModeConnector& connector) {
  const char* type = drmModeGetConnectorTypeName(connector.connector_type);
  return std::string(type != nullptr ? type : "Unknown") + "-" + std::to_string(connector.connector_type_id);
}

void read_crtcs(int fd, const drmModeConnector& from, Connector& connector) {
  for (const std::uint32_t id : std::span(from.encoders, static_cast<std::size_t>(from.count_encoders))) {
    const KernelEncoder encoder(drmModeGetEncoder(fd, id));
    if (!encoder) continue;
    connector.possible_crtcs |= encoder->possible_crtcs;
    if (id == from.encoder_id) connector.crtc_id = encoder->crtc_id;
  }
}

Connector read_connector(int fd, const drmModeConnector& from) {
  Connector connector;
  connector.id = from.connector_id;
  connector.name = name_of(from);
  connector.status = status_of(from.connection);
  connector.size = {static_cast<int>(from.mmWidth), static_cast<int>(from.mmHeight)};
  connector.modes.assign(from.modes, from.modes + from.count_modes);
  read_crtcs(fd, from, connector);
  return connector;
}

// Returns /dev/dri/card0, card1, ... in the order of their numbers.
std::vector<fs::path> card_paths() {
  std::vector<std::pair<int, fs::path>> found;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator("/dev/dri", none)) {
    const std::string name = entry.path().filename();
    if (name.starts_with("card")) found.emplace_back(std::atoi(name.c_str() + 4), entry.path());
  }
  std::ranges::sort(found);
  std::vector<fs::path> paths;
  for (auto& [number, path] : found)
    paths.push_back(std::move(path));
  return paths;
}

bool is_number(const std::string& text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

std::string content_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string process_text(const std::string& name, const std::string& pid) {
  return name + " (process " + pid + ")";
}

bool has_open(const fs::path& process, const fs::path& card) {
  std::error_code refused;
  for (const auto& entry : fs::directory_iterator(process / "fd", refused)) {
    if (fs::read_symlink(entry.path(), refused) == card) return true;
  }
  return false;
}

// True if the process is a child of this one: the light watchdog, which has the card from this process.
bool is_child(const fs::path& process) {
  return content_of(process / "status").find("\nPPid:\t" + std::to_string(::getpid()) + "\n") !=
         std::string::npos;
}

// Lists the visible processes that have the card open, except this one and its children.
std::string users_of(const fs::path& card) {
  std::string users;
  std::error_code refused;
  for (const auto& entry : fs::directory_iterator("/proc", refused)) {
    const std::string pid = entry.path().filename();
    if (!is_number(pid) || pid == std::to_string(::getpid()) || !has_open(entry.path(), card)) continue;
    if (is_child(entry.path())) continue;
    std::string name = content_of(entry.path() / "comm");
    if (!name.empty() && name.back() == '\n') name.pop_back();
    users += (users.empty() ? "" : ", ") + process_text(name, pid);
  }
  return users;
}

}  // namespace

Card::Card(const fs::path& path) : path_(path), fd_(opened(path)) {
  if (const Version version(drmGetVersion(fd())); version) driver_ = version->name;
  if (!Resources(drmModeGetResources(fd()))) throw HardwareError(name() + " has no outputs");
  // Lists primary planes as well, and modes with the picture's aspect ratio. Both only make the lists longer.
  drmSetClientCap(fd(), DRM_CLIENT_CAP_UNIVERSAL_PLANES, 1);
  drmSetClientCap(fd(), DRM_CLIENT_CAP_ASPECT_RATIO, 1);
}

dev_t Card::number() const {
  struct stat status {};
  return ::fstat(fd(), &status) == 0 ? status.st_rdev : dev_t{};
}

bool Card::is_master() const noexcept {
  return drmIsMaster(fd()) != 0;
}

bool Card::try_become_master() const noexcept {
  return is_master() || drmSetMaster(fd()) == 0;
}

void Card::become_master() const {
  if (try_become_master()) return;
  throw HardwareError(name() + " is in use: " + describe_master_holder(path_));
}

std::vector<Connector> Card::connectors() const {
  std::vector<Connector> connectors;
  const Resources resources(drmModeGetResources(fd()));
  if (!resources) return connectors;
  const auto count = static_cast<std::size_t>(resources->count_connectors);
  for (const std::uint32_t id : std::span(resources->connectors, count)) {
    const KernelConnector connector(drmModeGetConnector(fd(), id));
    if (!connector || connector->connector_type == DRM_MODE_CONNECTOR_WRITEBACK) continue;
    connectors.push_back(read_connector(fd(), *connector));
  }
  return connectors;
}

Connector Card::connector(std::uint32_t id) const {
  const KernelConnector connector(drmModeGetConnector(fd(), id));
  if (connector) return read_connector(fd(), *connector);
  Connector gone;
  gone.id = id;
  gone.status = Connector::Status::Disconnected;
  return gone;
}

std::vector<std::uint32_t> Card::crtcs() const {
  const Resources resources(drmModeGetResources(fd()));
  if (!resources) return {};
  return {resources->crtcs, resources->crtcs + resources->count_crtcs};
}

bool Card::has_monotonic_timestamps() const noexcept {
  std::uint64_t monotonic = 0;
  return drmGetCap(fd(), DRM_CAP_TIMESTAMP_MONOTONIC, &monotonic) == 0 && monotonic != 0;
}

bool Card::has_vblank(std::uint32_t crtc_id) const noexcept {
  std::uint64_t sequence = 0, time = 0;
  return drmCrtcGetSequence(fd(), crtc_id, &sequence, &time) == 0 || errno == EINVAL;
}

// The list's columns are command, thread group, device, master (y or n), authenticated, user, magic, and
// since Linux 6.12 name and id. A command may contain spaces.
std::optional<std::string> master_among(std::string_view clients) {
  std::istringstream lines{std::string(clients)};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    const std::vector<std::string> columns{std::istream_iterator<std::string>(words), {}};
    std::string command;
    for (std::size_t i = 0; i + 2 < columns.size(); ++i) {
      const std::string& master = columns[i + 2];
      if (i > 0 && is_number(columns[i]) && is_number(columns[i + 1]) && (master == "y" || master == "n")) {
        if (master == "y") return process_text(command, columns[i]);
        break;
      }
      command += (i == 0 ? "" : " ") + columns[i];
    }
  }
  return std::nullopt;
}

std::string describe_master_holder(const fs::path& card) {
  struct stat status {};
  if (::stat(card.c_str(), &status) == 0) {
    const std::string minor_number = std::to_string(minor(status.st_rdev));
    if (const auto master = master_among(content_of("/sys/kernel/debug/dri/" + minor_number + "/clients")))
      return *master + " is its DRM master";
  }
  if (const std::string users = users_of(card); !users.empty()) return users + " has it open";
  return "another program is its DRM master; run `fuser -v " + card.string() + "` as root to find it";
}

std::vector<Card> open_cards(const DrmDisplayConfig& config) {
  std::vector<Card> cards;
  std::string others;
  for (const auto& path : card_paths()) {
    try {
      Card card(path);
      if (!config.card || path == *config.card || card.driver() == *config.card) {
        cards.push_back(std::move(card));
        continue;
      }
      others += (others.empty() ? "" : "; ") + card.name();
    } catch (const HardwareError& error) {
      others += (others.empty() ? "" : "; ") + std::string(error.what());
    }
  }
  if (!cards.empty()) return cards;
  const std::string wanted = config.card ? " named " + *config.card : std::string(" with outputs");
  throw HardwareError("found no graphics card" + wanted + " in /dev/dri" +
                      (others.empty() ? "" : "; found: " + others));
}

OutputSearch find_output(const DrmDisplayConfig& config) {
  std::vector<Card> cards = open_cards(config);
  std::vector<CardOutputs> outputs;
  for (const Card& card : cards)
    outputs.push_back({card.name(), card.connectors()});
  const auto chosen = choose_output(outputs, config);
  if (!chosen) return {std::nullopt, "no display is connected; connectors: " + describe(outputs)};
  Card& card = cards[chosen->card];
  const Connector& connector = outputs[chosen->card].connectors[chosen->connector];
  if (connector.status == Connector::Status::Disconnected)
    return {std::nullopt,
            connector.name + " of " + card.name() + " is not connected; connectors: " + describe(outputs)};
  return {FoundOutput{std::move(card), connector}, {}};
}

}  // namespace contourd
