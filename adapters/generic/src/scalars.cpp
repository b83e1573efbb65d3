// C entry points of scalars.h. They check arguments and convert them to scene edits.
#include "fire3dv/scalars.h"

#include <string>
#include <utility>

#include "call.h"
#include "protocol/wire/check.h"
#include "scene_edits.h"
#include "stream.h"

using fire3dv::client::fail;
using fire3dv::client::guarded;
using fire3dv::client::set_edit;
using fire3dv::client::text_of;
namespace wire = fire3dv::wire;

namespace {

static_assert(FIRE3DV_MAX_SCALARS == wire::kMaxScalars);

int declare_scalars(fire3dv_stream* stream, const char* group, const fire3dv_scalars* scalars) {
  if (!group) return fail(FIRE3DV_ERROR_ARGUMENT, "group is NULL");
  if (const char* problem = fire3dv::client::struct_error(
          scalars, "scalars is NULL", "scalars.struct_size is not sizeof(fire3dv_scalars); set it"))
    return fail(FIRE3DV_ERROR_ARGUMENT, problem);
  if (scalars->count == 0 || !scalars->names)
    return fail(FIRE3DV_ERROR_ARGUMENT, "scalars.names is NULL or empty; clear the group instead");
  const wire::DecodeLimits limits = fire3dv::client::outgoing_limits();
  const std::string name = text_of(group, limits.max_name_bytes);
  size_t others = 0;
  for (const auto& [other, declared] : stream->scalar_groups)
    if (other != name) others += declared.count;
  if (scalars->count > wire::kMaxScalars - others)
    return fail(FIRE3DV_ERROR_BUDGET,
                "scalars.count is " + std::to_string(scalars->count) + ", and other groups have " +
                    std::to_string(others) +
                    "; a stream has at most 4096 scalars: clear groups, or declare fewer");
  wire::Scalars value;
  for (size_t i = 0; i < scalars->count; ++i) {
    if (!scalars->names[i])
      return fail(FIRE3DV_ERROR_ARGUMENT, "scalars.names[" + std::to_string(i) + "] is NULL");
    value.names.push_back(text_of(scalars->names[i], limits.max_name_bytes));
    value.units.push_back(text_of(scalars->units ? scalars->units[i] : nullptr, wire::kMaxScalarUnitBytes));
  }
  // Reserves its entry first: a group that renderers know must be known here.
  fire3dv_stream::ScalarGroup& entry = stream->scalar_groups[name];
  const int code = set_edit(stream, group, wire::Property::scalars, std::move(value));
  if (code == FIRE3DV_OK)
    entry = {stream->edits.version(), scalars->count};
  else if (entry.declaration == 0)
    stream->scalar_groups.erase(name);
  return code;
}

int set_scalars(fire3dv_stream* stream, const char* group, int64_t sim_time_ns, const double* values,
                size_t count) {
  if (!group) return fail(FIRE3DV_ERROR_ARGUMENT, "group is NULL");
  const std::string name = text_of(group, fire3dv::client::outgoing_limits().max_name_bytes);
  const auto declared = stream->scalar_groups.find(name);
  if (declared == stream->scalar_groups.end())
    return fail(FIRE3DV_ERROR_STATE, "the group of scalars \"" + wire::printable(name) +
                                         "\" is not declared: call fire3dv_declare_scalars first");
  if (!values) return fail(FIRE3DV_ERROR_ARGUMENT, "values is NULL");
  if (count != declared->second.count)
    return fail(FIRE3DV_ERROR_ARGUMENT, "count is " + std::to_string(count) + "; the group of scalars \"" +
                                            wire::printable(name) + "\" has " +
                                            std::to_string(declared->second.count));
  return set_edit(stream, group, wire::Property::scalar_values,
                  wire::ScalarValues{declared->second.declaration, sim_time_ns, {values, values + count}});
}

int clear_scalars(fire3dv_stream* stream, const char* group) {
  if (!group) return fail(FIRE3DV_ERROR_ARGUMENT, "group is NULL");
  const auto declared =
      stream->scalar_groups.find(text_of(group, fire3dv::client::outgoing_limits().max_name_bytes));
  if (declared == stream->scalar_groups.end()) return FIRE3DV_OK;
  for (const wire::Property property : {wire::Property::scalar_values, wire::Property::scalars})
    if (int code = set_edit(stream, group, property, wire::Cleared{})) return code;
  stream->scalar_groups.erase(declared);
  return FIRE3DV_OK;
}

}  // namespace

int fire3dv_declare_scalars(fire3dv_stream* stream, const char* group, const fire3dv_scalars* scalars) {
  return guarded(stream, [&] { return declare_scalars(stream, group, scalars); });
}

int fire3dv_set_scalars(fire3dv_stream* stream, const char* group, int64_t sim_time_ns, const double* values,
                        size_t count) {
  return guarded(stream, [&] { return set_scalars(stream, group, sim_time_ns, values, count); });
}

int fire3dv_clear_scalars(fire3dv_stream* stream, const char* group) {
  return guarded(stream, [&] { return clear_scalars(stream, group); });
}
