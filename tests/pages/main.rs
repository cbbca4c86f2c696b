//! What a release shows beside the program: the book, the report's page in a browser, the package.

mod book;
mod browser;
mod package;
