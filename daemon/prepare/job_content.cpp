#include "daemon/prepare/job_content.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/hollow/hollow_model.hpp"
#include "core/mask/picture_solid.hpp"
#include "core/repair/mesh_soundness.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// True if models of the same file with these tickets are turned and scaled alike.
bool made_alike(const ModelTicket& a, const ModelTicket& b) {
  return a.rotation == b.rotation && a.up == b.up && a.orientation == b.orientation && a.scale == b.scale &&
         a.fit == b.fit && a.unit == b.unit;
}

}  // namespace

JobContent::JobContent(const JobFiles& files, const JobTicket& ticket, bool unsupported)
    : files_of_job_(files), is_plate_(files.plate) {
  for (const ModelTicket& model : ticket.models)
    add(model, unsupported);
  is_plate_ = is_plate_ || models_.size() > 1;
  if (!is_archive_plate()) return;
  for (NamedModel& model : models_)
    model.name = printable(model.path);
}

void JobContent::add(const ModelTicket& ticket, bool unsupported) {
  auto opened = std::ranges::find_if(opened_, [&](const OpenedFile& other) {
    return other.name == ticket.file && other.entries == ticket.entries;
  });
  if (opened == opened_.end()) opened = opened_.insert(opened, open(ticket, unsupported));
  if (opened->count > 1 && (ticket.position || !ticket.drain.empty()))
    throw JobRefused(fmt::format(
        "{}the archive holds {} models, and {} in the ticket is for one: name one of them as \"model\"",
        ticket.file.empty() ? "" : printable(ticket.file) + ": ", opened->count,
        ticket.position ? "position_mm" : "drain"));
  for (std::size_t file = opened->first; file < opened->first + opened->count; ++file)
    add_model(ticket, file);
}

JobContent::OpenedFile JobContent::open(const ModelTicket& ticket, bool unsupported) {
  const bool plate = files_of_job_.plate;
  ModelFiles opened = open_model_files({plate ? files_of_job_.model / ticket.file : files_of_job_.model,
                                        {ticket.entries, unsupported},
                                        files_of_job_.links},
                                       printable(ticket.file));
  if (plate && opened.files.front().sliced() != nullptr)
    throw JobRefused(
        fmt::format("{} holds finished layers, which are those of a whole plate: print it by itself",
                    printable(ticket.file)));
  for (std::string& note : opened.notes)
    notes_.push_back(plate ? printable(ticket.file) + ": " + note : std::move(note));
  const OpenedFile made{ticket.file, ticket.entries, files_.size(), opened.files.size()};
  for (ModelFile& file : opened.files)
    files_.push_back(std::move(file));
  return made;
}

void JobContent::add_model(const ModelTicket& ticket, std::size_t file) {
  const auto alike = std::ranges::find_if(models_, [&](const NamedModel& other) {
    return other.file == file && made_alike(other.ticket, ticket);
  });
  const std::string& entry = files_[file].entry();
  const std::string path = ticket.file + (ticket.file.empty() || entry.empty() ? "" : "/") + entry;
  const auto made_as = static_cast<std::size_t>(alike - models_.begin());
  models_.push_back({ticket, files_of_job_.plate ? printable(path) : "the model", path, file, made_as});
}

void JobContent::leave_out(std::size_t model) {
  expects(is_archive_plate() && models_.size() > 1 && model < models_.size(),
          "a model of an archive can be left out, but not the last one");
  models_.erase(models_.begin() + static_cast<std::ptrdiff_t>(model));
  // Each model of an archive is made from a file of its own.
  for (std::size_t i = 0; i < models_.size(); ++i)
    models_[i].made_as = i;
}

bool JobContent::is_first_of_file(std::size_t model) const {
  return std::none_of(models_.begin(), models_.begin() + static_cast<std::ptrdiff_t>(model),
                      [&](const NamedModel& other) { return other.file == models_[model].file; });
}

Model JobContent::read_layers(const DisplayGeometry& display, const std::stop_token& stop) {
  // Half a gigabyte is twenty times what a print of 4000 dense layers takes.
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 29U;
  finished_ = files_.front().read_layers(display, std::min(kMostBytes, room_.bytes - needed_), stop);
  Model box;
  box.facets = finished_.outlines ? box_of(*finished_.outlines) : box_of(*finished_.pictures, display);
  const Point middle = bounds_of(box.facets).center();
  ModelTicket& ticket = models_.front().ticket;
  ticket.scale = Scale{1};
  ticket.position = PlateOffset{Millimeters{middle.x}, Millimeters{middle.y}};
  return box;
}

void JobContent::read(const DisplayGeometry& display, const MemoryRoom& room, const std::stop_token& stop) {
  for (const ModelFile& file : files_)
    to_read_.push_back({file.outline(), 0});
  for (std::size_t i = 0; i < models_.size(); ++i)
    if (models_[i].made_as == i) ++to_read_[models_[i].file].models;
  needed_ = memory_to_prepare(to_read_, display);
  room_ = room;
  if (needed_ > room_.bytes) throw JobTooLarge(to_read_, "", needed_, room_);
  for (std::size_t i = 0; i < files_.size(); ++i) {
    read_.push_back(sliced() != nullptr ? read_layers(display, stop)
                                        : files_[i].read(most_facets_to_read(to_read_, i, display, room_)));
    // The facets that there are, instead of those that the file's beginning promised.
    to_read_[i].outline.most_facets = read_[i].facets.size();
    to_read_[i].outline.exact = true;
    to_read_[i].outline.buffered_bytes += finished_.bytes();
  }
  needed_ = memory_to_prepare(to_read_, display);
}

bool JobContent::has_room_to_repair(std::size_t facets) const {
  return needed_ + memory_to_repair(facets) <= room_.bytes;
}

void JobContent::require_room_to_repair(std::span<const Facet> facets) {
  const std::uint64_t repairing = memory_to_repair(facets.size());
  if (!has_room_to_repair(facets.size())) {
    if (is_sound(facets)) return;
    throw JobTooLarge(to_read_, ", which have to be repaired", needed_ + repairing, room_);
  }
  repairing_ = std::max(repairing_, repairing);
}

void JobContent::require_room_for_masks(std::span<const PlateModel> models, bool moved,
                                        std::uint64_t more) const {
  const std::uint64_t others = needed_ + more;
  if (others + repairing_ + most_memory_for_sections(models, moved) <= room_.bytes) return;
  const std::uint64_t needed = others + memory_for_sections(models, moved);
  if (needed > room_.bytes) throw JobTooLarge(to_read_, ", many of them at one height", needed, room_);
}

void JobContent::require_room_to_hollow(const Bounds& model, Millimeters pixel) const {
  const std::uint64_t needed = needed_ + memory_to_hollow(model, pixel);
  if (needed > room_.bytes) throw JobTooLarge(to_read_, ", one of them hollowed", needed, room_);
}

void JobContent::require_room_for_supports(std::span<const PlateModel> models,
                                           const DisplayGeometry& display) const {
  const std::uint64_t needed = needed_ + memory_for_supports(display);
  if (needed + most_memory_for_sections(models, false) <= room_.bytes) return;
  const std::uint64_t with_sections = needed + memory_for_sections(models, false);
  if (with_sections > room_.bytes) throw JobTooLarge(to_read_, ", with supports", with_sections, room_);
}

std::vector<Facet> JobContent::take_facets(std::size_t model) {
  std::vector<Facet>& facets = read_[models_[model].file].facets;
  for (std::size_t later = model + 1; later < models_.size(); ++later)
    if (models_[later].file == models_[model].file && models_[later].made_as == later) return facets;
  return std::move(facets);
}

}  // namespace contourd
