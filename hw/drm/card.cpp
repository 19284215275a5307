#include "hw/drm/card.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/stat.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <utility>

#include "hw/drm/libdrm_pointer.hpp"
#include "hw/drm/master_holder.hpp"
#include "hw/hardware_error.hpp"

namespace contourd {
namespace {

using Resources = LibdrmPointer<drmModeRes, drmModeFreeResources>;
using KernelConnector = LibdrmPointer<drmModeConnector, drmModeFreeConnector>;
using KernelEncoder = LibdrmPointer<drmModeEncoder, drmModeFreeEncoder>;
using Version = LibdrmPointer<drmVersion, drmFreeVersion>;

// "; members of the group video may open it"
std::string who_may_open(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return "";
  const group* owner = ::getgrgid(status.st_gid);
  return "; members of the group " +
         (owner != nullptr ? std::string(owner->gr_name) : std::to_string(status.st_gid)) + " may open it";
}

FileDescriptor opened(const std::filesystem::path& path) {
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
std::vector<std::filesystem::path> card_paths() {
  std::vector<std::pair<int, std::filesystem::path>> found;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/dev/dri", none)) {
    const std::string name = entry.path().filename();
    if (name.starts_with("card")) found.emplace_back(std::atoi(name.c_str() + 4), entry.path());
  }
  std::ranges::sort(found);
  std::vector<std::filesystem::path> paths;
  for (auto& [number, path] : found)
    paths.push_back(std::move(path));
  return paths;
}

}  // namespace

Card::Card(const std::filesystem::path& path) : path_(path), fd_(opened(path)) {
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
