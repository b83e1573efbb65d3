// Function table of the SQLite library, loaded at run time: few runs need it. Its binary interface is stable
// (sqlite.org/capi3ref.html), so that no header is needed.
#pragma once

#include <cstdint>

#include "base/error.h"

struct sqlite3;
struct sqlite3_stmt;

namespace fire3dv::imported {

// Values of sqlite3.h.
constexpr int kSqliteOk = 0, kSqliteRow = 100, kSqliteDone = 101;
constexpr int kSqliteOpenReadOnly = 1;
constexpr int kSqliteLimitLength = 0;  // bytes of a value

struct SqliteLibrary {
  int (*sqlite3_open_v2)(const char* file, sqlite3** database, int flags, const char* vfs) = nullptr;
  int (*sqlite3_close_v2)(sqlite3* database) = nullptr;
  int (*sqlite3_limit)(sqlite3* database, int limit, int value) = nullptr;
  void (*sqlite3_progress_handler)(sqlite3* database, int instructions, int (*handler)(void*),
                                   void* argument) = nullptr;
  int (*sqlite3_prepare_v2)(sqlite3* database, const char* sql, int bytes, sqlite3_stmt** statement,
                            const char** rest) = nullptr;
  int (*sqlite3_step)(sqlite3_stmt* statement) = nullptr;
  int (*sqlite3_finalize)(sqlite3_stmt* statement) = nullptr;
  int64_t (*sqlite3_column_int64)(sqlite3_stmt* statement, int column) = nullptr;
  const unsigned char* (*sqlite3_column_text)(sqlite3_stmt* statement, int column) = nullptr;
  const void* (*sqlite3_column_blob)(sqlite3_stmt* statement, int column) = nullptr;
  int (*sqlite3_column_bytes)(sqlite3_stmt* statement, int column) = nullptr;
  const char* (*sqlite3_errmsg)(sqlite3* database) = nullptr;
};

// Process-wide table, loaded at the first call. The error names the missing library and its package.
Result<const SqliteLibrary*> load_sqlite();

}  // namespace fire3dv::imported
