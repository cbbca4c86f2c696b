//! What a release shows beside the program: the book, and the report's page in a browser.

mod book;
mod browser;
