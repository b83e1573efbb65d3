#include "protocol/import/files/sqlite_library.h"

#include <dlfcn.h>

#include <string>
#include <type_traits>

namespace fire3dv::imported {
namespace {

Result<SqliteLibrary> load() {
  constexpr const char* kName = "libsqlite3.so.0";
  void* const library = ::dlopen(kName, RTLD_NOW | RTLD_LOCAL);
  if (!library)
    return Error{
        std::string("bags with .db3 files need ") + kName +
        ", which is not there: install the package libsqlite3-0, or convert the bag to MCAP (ros2 bag "
        "convert)"};
  SqliteLibrary table;
  std::string missing;
  const auto find = [&](auto& function, const char* name) {
    void* const found = ::dlsym(library, name);
    if (!found && missing.empty()) missing = name;
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(found);
  };
#define FIRE3DV_FIND(function) find(table.function, #function)
  FIRE3DV_FIND(sqlite3_open_v2);
  FIRE3DV_FIND(sqlite3_close_v2);
  FIRE3DV_FIND(sqlite3_limit);
  FIRE3DV_FIND(sqlite3_progress_handler);
  FIRE3DV_FIND(sqlite3_prepare_v2);
  FIRE3DV_FIND(sqlite3_step);
  FIRE3DV_FIND(sqlite3_finalize);
  FIRE3DV_FIND(sqlite3_column_int64);
  FIRE3DV_FIND(sqlite3_column_text);
  FIRE3DV_FIND(sqlite3_column_blob);
  FIRE3DV_FIND(sqlite3_column_bytes);
  FIRE3DV_FIND(sqlite3_errmsg);
#undef FIRE3DV_FIND
  if (!missing.empty()) return Error{"the SQLite library of this system has no " + missing};
  return table;
}

}  // namespace

Result<const SqliteLibrary*> load_sqlite() {
  static const Result<SqliteLibrary> loaded = load();
  if (!loaded) return loaded.error();
  return &*loaded;
}

}  // namespace fire3dv::imported
