#include "daemon/prepare/job_content.hpp"

#include <algorithm>
#include <utility>

#include "core/repair/mesh_soundness.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// True if both models are made from the same file, turned and scaled alike.
bool made_alike(const ModelTicket& a, const ModelTicket& b) {
  return a.file == b.file && a.entry == b.entry && a.rotation == b.rotation && a.up == b.up &&
         a.orientation == b.orientation && a.scale == b.scale && a.fit == b.fit && a.unit == b.unit;
}

}  // namespace

JobContent::JobContent(const std::filesystem::path& folder_or_model, bool plate, Links links,
                       const JobTicket& ticket) {
  for (const ModelTicket& model : ticket.models)
    add(model, folder_or_model, plate, links);
}

void JobContent::add(const ModelTicket& ticket, const std::filesystem::path& folder_or_model, bool plate,
                     Links links) {
  const auto same_file = std::find_if(models_.begin(), models_.end(), [&](const NamedModel& other) {
    return other.ticket.file == ticket.file && other.ticket.entry == ticket.entry;
  });
  const auto alike = std::find_if(same_file, models_.end(),
                                  [&](const NamedModel& other) { return made_alike(other.ticket, ticket); });
  const std::size_t file = same_file == models_.end() ? files_.size() : same_file->file;
  if (file == files_.size())
    files_.emplace_back(
        ModelPlace{plate ? folder_or_model / ticket.file : folder_or_model, ticket.entry, links},
        printable(ticket.file));
  const auto made_as = static_cast<std::size_t>(alike - models_.begin());
  models_.push_back({ticket, plate ? printable(ticket.file) : "the model", file, made_as});
}

bool JobContent::is_first_of_file(std::size_t model) const {
  return std::none_of(models_.begin(), models_.begin() + static_cast<std::ptrdiff_t>(model),
                      [&](const NamedModel& other) { return other.file == models_[model].file; });
}

void JobContent::read(const DisplayGeometry& display, const MemoryRoom& room) {
  for (const ModelFile& file : files_)
    to_read_.push_back({file.outline(), 0});
  for (std::size_t i = 0; i < models_.size(); ++i)
    if (models_[i].made_as == i) ++to_read_[models_[i].file].models;
  needed_ = memory_to_prepare(to_read_, display);
  room_ = room;
  if (needed_ > room_.bytes) throw JobTooLarge(to_read_, "", needed_, room_);
  for (std::size_t i = 0; i < files_.size(); ++i) {
    read_.push_back(files_[i].read(most_facets_to_read(to_read_, i, display, room_)));
    // The facets that there are, instead of those that the file's beginning promised.
    to_read_[i].outline.most_facets = read_[i].facets.size();
    to_read_[i].outline.exact = true;
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
